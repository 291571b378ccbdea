#include "detection/freespace/open_sky.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// Measured: with 5 degrees to the side, some panes of parked cars 3 m away are wider.
constexpr double kSkyColumns_rad = 7.5 * kDegree, kSkyRows_rad = 2 * kDegree;

// By laser, then column of the aligned image.
class Cells {
 public:
  explicit Cells(const LidarScan& scan)
      : columns_(static_cast<std::size_t>(scan.columns)),
        set_(static_cast<std::size_t>(scan.rows()) * columns_) {}
  [[nodiscard]] bool at(int row, int column) const { return set_[index(row, column)]; }
  void set(int row, int column, bool value) { set_[index(row, column)] = value; }

 private:
  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
  }
  std::size_t columns_;
  std::vector<bool> set_;
};

Cells returns_of(const LidarScan& scan, const AlignedImage& image) {
  Cells out(scan);
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) out.set(l, c, scan.cell(l, image.scan_column(l, c)) >= 0);
  }
  return out;
}

// Cells with a return of their own laser within kSkyColumns_rad.
Cells beside_returns(const LidarScan& scan, const Cells& returned) {
  const int columns = scan.columns;
  const int wanted = static_cast<int>(std::lround(kSkyColumns_rad * columns / (2 * std::numbers::pi)));
  const int reach = std::min(std::max(1, wanted), (columns - 1) / 2);
  Cells out(scan);
  for (int l = 0; l < scan.rows(); ++l) {
    const auto one = [&](int c) { return returned.at(l, (c + columns) % columns) ? 1 : 0; };
    int near = 0;  // returns from c - reach to c + reach
    for (int c = -reach; c < reach; ++c) near += one(c);
    for (int c = 0; c < columns; ++c) {
      near += one(c + reach);
      out.set(l, c, near > 0);
      near -= one(c - reach);
    }
  }
  return out;
}

struct Rows {
  int first, last;
};

// Those within kSkyRows_rad, and at least the next on either side.
Rows rows_about(const LidarModel& model, int row) {
  const auto angle = [&](int l) {
    return std::abs(model.lasers[static_cast<std::size_t>(l)].elevation_rad -
                    model.lasers[static_cast<std::size_t>(row)].elevation_rad);
  };
  const int last = static_cast<int>(model.lasers.size()) - 1;
  Rows out{std::max(0, row - 1), std::min(last, row + 1)};
  while (out.first > 0 && angle(out.first - 1) <= kSkyRows_rad) --out.first;
  while (out.last < last && angle(out.last + 1) <= kSkyRows_rad) ++out.last;
  return out;
}

bool says_why(const LidarScan& scan) {
  return std::find(scan.cells.begin(), scan.cells.end(), empty_cell(ReturnCode::nothing)) != scan.cells.end();
}

}  // namespace

std::vector<bool> open_sky(const LidarScan& scan) {
  std::vector<bool> open;
  if (scan.columns == 0 || says_why(scan)) return open;
  open.resize(scan.cells.size());
  const AlignedImage image(scan);
  const Cells returned = returns_of(scan, image), beside = beside_returns(scan, returned);
  std::vector<bool> returned_below(static_cast<std::size_t>(scan.columns));
  for (int l = 0; l < scan.rows(); ++l) {
    const Rows rows = rows_about(*scan.model, l);
    for (int c = 0; c < scan.columns; ++c) {
      if (returned.at(l, c)) returned_below[static_cast<std::size_t>(c)] = true;
      if (!returned_below[static_cast<std::size_t>(c)]) continue;
      bool alone = true;
      for (int row = rows.first; row <= rows.last && alone; ++row) alone = !beside.at(row, c);
      if (!alone) continue;
      const auto cell = static_cast<std::size_t>(l) * static_cast<std::size_t>(scan.columns) +
                        static_cast<std::size_t>(image.scan_column(l, c));
      open[cell] = true;
    }
  }
  return open;
}

}  // namespace mapless
