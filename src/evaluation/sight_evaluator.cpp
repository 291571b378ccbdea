#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "evaluation/scan_checks.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kInfinite_m = std::numeric_limits<double>::infinity();

// Walks along the cells of one laser, once round to fill its memory and once more to use it.
class Neighbours {
 public:
  Neighbours(const LidarScan& scan, const ScanLabels& labels, int row)
      : scan_(scan), labels_(labels), row_(row) {
    reach_ = static_cast<int>(std::floor(kGapReach_deg / 360 * scan.columns));
  }

  // For every column: whether the first other cell, walked to from there against `direction`, saw nothing.
  [[nodiscard]] std::vector<char> sky(int direction) const {
    const int columns = scan_.columns;
    std::vector<char> out(static_cast<std::size_t>(columns), 0);
    std::int64_t object = kNone;  // of the last hit
    bool before_object = false;   // the cell before its run of hits saw nothing
    bool last_nothing = false;
    for (int step = 0; step < 2 * columns; ++step) {
      const int column = (direction > 0 ? step : 2 * columns - 1 - step) % columns;
      const std::int32_t cell = scan_.cell(row_, column);
      if (cell < 0) {
        if (code_of_cell(cell) != ReturnCode::nothing) continue;
        last_nothing = true;
        object = kNone;
        continue;
      }
      if (const std::int64_t id = truth(cell) >> 16; id != object) {
        before_object = last_nothing;
        object = id;
      }
      last_nothing = false;
      out[static_cast<std::size_t>(column)] = before_object ? 1 : 0;
    }
    return out;
  }

  // Range of the nearest static return within reach of the column in `direction`; infinite for none.
  [[nodiscard]] double nearest_static_m(int column, int direction) const {
    double nearest_m = kInfinite_m;
    for (int i = 1; i <= reach_; ++i) {
      const int c = (column + direction * i + scan_.columns) % scan_.columns;
      const std::int32_t cell = scan_.cell(row_, c);
      if (cell < 0 || motion_of_label(truth(cell)) != MotionTruth::still) continue;
      nearest_m = std::min(nearest_m, static_cast<double>(returned(cell).range_m));
    }
    return nearest_m;
  }

 private:
  static constexpr std::int64_t kNone = -1;

  [[nodiscard]] const LidarReturn& returned(std::int32_t cell) const {
    return scan_.returns[static_cast<std::size_t>(cell)];
  }
  [[nodiscard]] std::uint32_t truth(std::int32_t cell) const {
    return labels_.truth[returned(cell).input_index];
  }

  const LidarScan& scan_;
  const ScanLabels& labels_;
  int row_;
  int reach_ = 0;
};

void add_to(Found& found, bool hit) {
  found.found += hit ? 1 : 0;
  ++found.of;
}

}  // namespace

SightEvaluator::SightEvaluator(std::optional<double> max_range_m) : max_range_m_(max_range_m) {
  if (max_range_m_) require_range_limit("SightEvaluator", *max_range_m_);
}

void SightEvaluator::add(const LidarScan& scan, const ScanLabels& labels) {
  require_equal_lengths(labels.number, scan.input_size, labels.result.size(), labels.ranges_m.size());
  require_equal_lengths(labels.number, labels.truth.size(), labels.result.size(), labels.ranges_m.size());
  for (int row = 0; row < scan.rows(); ++row) add_row(scan, labels, row);
}

void SightEvaluator::add_row(const LidarScan& scan, const ScanLabels& labels, int row) {
  std::vector<int> dynamic;  // columns
  for (int column = 0; column < scan.columns; ++column) {
    const std::int32_t cell = scan.cell(row, column);
    if (cell < 0) continue;
    const LidarReturn& point = scan.returns[static_cast<std::size_t>(cell)];
    if (max_range_m_ && !(static_cast<double>(point.range_m) <= *max_range_m_)) continue;
    if (motion_of_label(labels.truth[point.input_index]) == MotionTruth::moving) dynamic.push_back(column);
  }
  if (dynamic.empty()) return;
  const Neighbours neighbours(scan, labels, row);
  const std::vector<char> sky_before = neighbours.sky(+1), sky_after = neighbours.sky(-1);
  for (const int column : dynamic) {
    const LidarReturn& point = scan.returns[static_cast<std::size_t>(scan.cell(row, column))];
    const bool called = motion_of_label(labels.result[point.input_index]) == MotionTruth::moving;
    const double occluded_m = static_cast<double>(point.range_m) - kGapDepth_m;
    if (neighbours.nearest_static_m(column, -1) < occluded_m &&
        neighbours.nearest_static_m(column, +1) < occluded_m)
      add_to(report_.through_gap, called);
    const auto c = static_cast<std::size_t>(column);
    if (sky_before[c] != 0 && sky_after[c] != 0) add_to(report_.before_sky, called);
  }
}

}  // namespace mapless
