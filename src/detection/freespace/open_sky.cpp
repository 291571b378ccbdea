#include "detection/freespace/open_sky.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The rays about a ray: half the width and height, and at least so many lasers up and down.
struct SkyWindow {
  double columns_rad, rows_rad;
  int lasers;
};
// Measured: with 5 degrees to the side, some panes of parked cars 3 m away are wider; with less than three
// beside what is wide, the paint about them is taken for sky.
constexpr SkyWindow kWide{7.5 * kDegree, 2 * kDegree, 1}, kBesideWide{3 * kDegree, 1 * kDegree, 0};

// A ray is not covered if a ray of its laser within this angle has returned before: firings jitter.
constexpr double kUncovered_rad = 1 * kDegree;

// A laser that has returned in less than this part of the turn looks at the sky: a cover would span the rest.
// Measured: with a half, there are false objects where half of the view is covered.
constexpr double kSkyRing = 0.25;

// By laser, then column of the aligned image.
class Cells {
 public:
  explicit Cells(const LidarScan& scan)
      : rows_(scan.rows()), columns_(scan.columns), set_(scan.cells.size()) {}
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] bool at(int row, int column) const { return set_[index(row, column)] != 0; }
  void set(int row, int column, bool value = true) { set_[index(row, column)] = value ? 1 : 0; }

 private:
  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  int rows_, columns_;
  std::vector<char> set_;  // faster than bits
};

Cells returns_of(const LidarScan& scan, const AlignedImage& image) {
  Cells out(scan);
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c) out.set(l, c, scan.cell(l, image.scan_column(l, c)) >= 0);
  }
  return out;
}

// Cells with a return of their own laser within the angle, or in the next column.
Cells beside_returns(const LidarScan& scan, const Cells& returned, double angle_rad) {
  const int columns = scan.columns;
  const int wanted = static_cast<int>(std::lround(angle_rad * columns / (2 * std::numbers::pi)));
  const int reach = std::min(std::max(1, wanted), (columns - 1) / 2);
  Cells out(scan);
  for (int l = 0; l < scan.rows(); ++l) {
    const auto one = [&](int c) {
      return returned.at(l, c < 0 ? c + columns : c < columns ? c : c - columns) ? 1 : 0;
    };
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

Rows rows_about(const LidarModel& model, int row, const SkyWindow& window) {
  const auto angle = [&](int l) {
    return std::abs(model.lasers[static_cast<std::size_t>(l)].elevation_rad -
                    model.lasers[static_cast<std::size_t>(row)].elevation_rad);
  };
  const int last = static_cast<int>(model.lasers.size()) - 1;
  Rows out{std::max(0, row - window.lasers), std::min(last, row + window.lasers)};
  while (out.first > 0 && angle(out.first - 1) <= window.rows_rad) --out.first;
  while (out.last < last && angle(out.last + 1) <= window.rows_rad) ++out.last;
  return out;
}

// Those of the candidates about which no ray within the window returned.
Cells empty_about(const LidarScan& scan, const Cells& returned, const Cells& candidates,
                  const SkyWindow& window) {
  const Cells beside = beside_returns(scan, returned, window.columns_rad);
  Cells out(scan);
  for (int l = 0; l < scan.rows(); ++l) {
    const Rows rows = rows_about(*scan.model, l, window);
    for (int c = 0; c < scan.columns; ++c) {
      bool empty = candidates.at(l, c);
      for (int row = rows.first; row <= rows.last && empty; ++row) empty = !beside.at(row, c);
      out.set(l, c, empty);
    }
  }
  return out;
}

// `from`, and all of `through` that is linked to it by neighbours of one row or column.
Cells reached(Cells from, const Cells& through) {
  std::vector<std::pair<int, int>> todo;
  const auto reach = [&](int l, int c) {
    if (l < 0 || l >= through.rows() || from.at(l, c) || !through.at(l, c)) return;
    from.set(l, c);
    todo.emplace_back(l, c);
  };
  const auto reach_about = [&](int l, int c) {
    reach(l - 1, c);
    reach(l + 1, c);
    reach(l, (c + 1) % through.columns());
    reach(l, (c + through.columns() - 1) % through.columns());
  };
  for (int l = 0; l < through.rows(); ++l) {
    for (int c = 0; c < through.columns(); ++c) {
      if (from.at(l, c)) reach_about(l, c);
    }
  }
  while (!todo.empty()) {
    const auto [l, c] = todo.back();
    todo.pop_back();
    reach_about(l, c);
  }
  return from;
}

bool says_why(const LidarScan& scan) {
  return std::find(scan.cells.begin(), scan.cells.end(), empty_cell(ReturnCode::nothing)) != scan.cells.end();
}

// Whether the laser has returned in less than kSkyRing of the turn.
bool looks_at_sky(const std::vector<bool>& returned_once) {
  const auto columns = static_cast<double>(returned_once.size());
  return static_cast<double>(std::count(returned_once.begin(), returned_once.end(), true)) <
         kSkyRing * columns;
}

// The azimuth of a column of the aligned image, in columns of the turn: scans may begin anywhere.
std::size_t azimuth_column(const LidarModel& model, int column) {
  const double turns = model.hub_angle(column) / (2 * std::numbers::pi);
  const auto nearest = std::lround((turns - std::floor(turns)) * model.columns);
  return static_cast<std::size_t>(nearest % model.columns);
}

// Learns from the scan which rays return at all. Then the cells that are not covered, as far as is known.
Cells uncovered(const LidarScan& scan, const Cells& returned, std::vector<std::vector<bool>>& returned_once) {
  const Cells returns_now = beside_returns(scan, returned, kUncovered_rad);
  Cells out(scan);
  std::vector<std::size_t> azimuth;
  for (int c = 0; c < scan.columns; ++c) azimuth.push_back(azimuth_column(*scan.model, c));
  std::vector<bool> returned_below(azimuth.size());
  for (int l = 0; l < scan.rows(); ++l) {
    std::vector<bool>& once = returned_once[static_cast<std::size_t>(l)];
    for (int c = 0; c < scan.columns; ++c) {
      if (returns_now.at(l, c)) once[azimuth[static_cast<std::size_t>(c)]] = true;
    }
    const bool sky = looks_at_sky(once);
    for (int c = 0; c < scan.columns; ++c) {
      const auto column = static_cast<std::size_t>(c);
      if (returned.at(l, c)) returned_below[column] = true;
      out.set(l, c, returned_below[column] && (sky || once[azimuth[column]]));
    }
  }
  return out;
}

}  // namespace

std::vector<bool> OpenSky::of_next(const LidarScan& scan) {
  std::vector<bool> open;
  told_ = told_ || says_why(scan);
  if (scan.columns == 0 || told_) return open;
  const AlignedImage image(scan);
  const Cells returned = returns_of(scan, image);
  const std::vector<bool> never(static_cast<std::size_t>(scan.model->columns));
  if (returned_once_.size() != scan.model->lasers.size() || returned_once_.front().size() != never.size())
    returned_once_.assign(scan.model->lasers.size(), never);
  const Cells candidates = uncovered(scan, returned, returned_once_);
  const Cells free = reached(empty_about(scan, returned, candidates, kWide),
                             empty_about(scan, returned, candidates, kBesideWide));
  open.resize(scan.cells.size());
  for (int l = 0; l < scan.rows(); ++l) {
    for (int c = 0; c < scan.columns; ++c)
      open[static_cast<std::size_t>(l * scan.columns + image.scan_column(l, c))] = free.at(l, c);
  }
  return open;
}

}  // namespace mapless
