#include "detection/own_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mapless::inline v1 {
namespace {

// Between two key scans a static surface moves in the sensor frame by this much, or by this angle: over
// kFewestFirstKeyScans, by two tolerances and more. Chosen.
constexpr double kKeyDistance_m = 0.05;
constexpr double kKeyAngle_rad = 0.025;

// Longer than a lorry with trailer behind its cab, or a bus. Chosen.
constexpr float kLargestRange_m = 18;

// Half a metre of motion, and half a second with ten scans a second; the first labels wait for five scans,
// too. From kFewestKeyScans on, some of them may have had another range. Chosen.
constexpr int kFewestFirstKeyScans = 5;
constexpr int kFewestKeyScans = 10;

// Chosen: one range in ten may be an outlier, or that of something in front of the own vehicle.
constexpr int kSamePerOther = 9;

// The range of a cell is the mean of its first so many, which are half as noisy as one. A mean of all would
// follow a surface that slowly recedes.
constexpr int kAveraged = 4;

// A cell without another range may lack returns in two of ten of the first key scans: see kMostBridged.
constexpr int kReturnedPerTen = 8;

// Counts are halved at this sum, so that the last hundred key scans decide.
constexpr int kRemembered = 200;

// A new range has at most so many others against it: then it is taken after 90 key scans.
constexpr int kMostOthers = 10;

// A run of constant cells ends freely where at most half of the next kBeyondEnd columns have a return within
// kLinked_m of its last range, and none of them but the first, where firings jitter, had such a range in
// more than three of ten key scans and another range since or before. Where an end moves by D columns in the
// key scans so far, the columns beyond the constant ones had the surface in 1 - 1/D, 1 - 2/D, ... of them.
// Measured: docs/notebook/detection.md, "The sensor's own vehicle".
constexpr int kBeyondEnd = 4;
constexpr float kLinked_m = 0.2F;
constexpr int kEndedPerTen = 3;

// So many cells beside one another may have too few returns yet: of paint that returns every second firing,
// one cell in seven after five key scans. Chosen.
constexpr int kMostBridged = 8;

// By so many key scans the own vehicle is remembered: behind and beside its parts other things come and go,
// and whether a run ends freely with them. Chosen: half a second.
constexpr int kMostOwn = 5;

// Firings jitter by a column from scan to scan.
constexpr int kColumnsAside = 2;

// The range nearest to `range_m` of the returns of a laser in `column` and at most `aside` beside it; 0:
// none.
float nearest(const LidarScan& scan, int laser, int column, int aside, float range_m) {
  float best = 0;
  for (int c = std::max(column - aside, 0); c <= std::min(column + aside, scan.columns - 1); ++c) {
    const std::int32_t i = scan.cell(laser, c);
    if (i < 0) continue;
    const float seen_m = scan.returns[static_cast<std::size_t>(i)].range_m;
    if (best == 0 || std::abs(seen_m - range_m) < std::abs(best - range_m)) best = seen_m;
  }
  return best;
}

}  // namespace

bool OwnVehicle::Cell::constant(int key_scans) const {
  const int needed = others > 0 ? key_scans : key_scans * kReturnedPerTen / 10;
  return same >= std::clamp(needed, kFewestFirstKeyScans, kFewestKeyScans) && same >= kSamePerOther * others;
}

void OwnVehicle::Cell::add(float seen_m, float tolerance_m) {
  if (range_m > 0 && std::abs(seen_m - range_m) <= tolerance_m) {
    ++same;
    if (same <= kAveraged) range_m += (seen_m - range_m) / static_cast<float>(same);
  } else if (++others > same) {
    range_m = seen_m < kLargestRange_m ? seen_m : 0;
    others = static_cast<std::uint8_t>(std::min(same + others - 1, kMostOthers));
    same = range_m > 0 ? 1 : 0;
    own = 0;
  }
  if (same + others >= kRemembered) {
    same /= 2;
    others /= 2;
  }
}

std::size_t OwnVehicle::cell_index(int row, int column) const {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(model_->columns) +
         static_cast<std::size_t>(column);
}

bool OwnVehicle::is_key_scan(const SE3& T_v0) {
  if (key_T_v0_) {
    const SE3 motion = T_v0 * key_T_v0_->inverse();
    if (motion.translation().norm() < kKeyDistance_m && so3_log(motion.rotation()).norm() < kKeyAngle_rad)
      return false;
  }
  key_T_v0_ = T_v0;
  return true;
}

void OwnVehicle::count_ranges(const LidarScan& scan, float tolerance_m) {
  if (model_ != scan.model) {
    model_ = scan.model;
    cells_.assign(model_->lasers.size() * static_cast<std::size_t>(model_->columns), {});
    key_scans_ = 0;
  }
  ++key_scans_;
  const int columns = std::min(model_->columns, scan.columns);
  for (int row = 0; row < scan.rows(); ++row) {
    for (int c = 0; c < columns; ++c) count_range(scan, row, c, tolerance_m);
  }
}

void OwnVehicle::count_range(const LidarScan& scan, int row, int column, float tolerance_m) {
  Cell& cell = cells_[cell_index(row, column)];
  const std::int32_t i = scan.cell(row, column);
  if (i < 0) {  // dark paint returns one firing in two: those beside it tell, but only for the range
    if (cell.range_m == 0) return;
    const float beside_m = nearest(scan, row, column, kColumnsAside, cell.range_m);
    if (std::abs(beside_m - cell.range_m) <= tolerance_m) cell.add(beside_m, tolerance_m);
    return;
  }
  const float seen_m = scan.returns[static_cast<std::size_t>(i)].range_m;
  if (cell.range_m > 0) {
    cell.add(nearest(scan, row, column, 1, cell.range_m), tolerance_m);
  } else if (seen_m < kLargestRange_m) {
    cell.add(seen_m, tolerance_m);
  } else if (cell.others == 0) {
    cell.others = 1;
  }
}

std::vector<OwnVehicle::Run> OwnVehicle::all_runs(const LidarScan& scan) const {
  std::vector<Run> runs;
  for (int row = 0; row < scan.rows(); ++row) {
    std::vector<std::vector<int>> of_row = constant_runs(row);
    for (std::vector<int>& columns : of_row) {
      // A run all around has no end. It is the own vehicle or flat ground: static, either way.
      const bool ring =
          of_row.size() == 1 && static_cast<int>(columns.size()) + kColumnsAside >= model_->columns;
      const bool free =
          ring || (ends_freely(scan, row, columns.front(), -1) && ends_freely(scan, row, columns.back(), 1));
      runs.push_back({row, free, std::move(columns)});
    }
  }
  return runs;
}

// A body: the runs of neighbouring rows with cells one above the other on one surface, and so on.
DisjointSets OwnVehicle::bodies_of(const std::vector<Run>& runs) const {
  DisjointSets bodies(runs.size());
  const auto columns = static_cast<std::size_t>(model_->columns);
  std::vector<std::int32_t> run_at(cells_.size(), -1);
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(runs.size()); ++k) {
    const Run& run = runs[static_cast<std::size_t>(k)];
    for (const int c : run.columns) {
      const std::size_t at = cell_index(run.row, c);
      run_at[at] = k;
      if (run.row == 0 || run_at[at - columns] < 0) continue;
      if (std::abs(cells_[at].range_m - cells_[at - columns].range_m) <= kLinked_m)
        bodies.unite(run_at[at - columns], k);
    }
  }
  return bodies;
}

// The cells of the bodies at least half of whose cells are in runs that end freely.
void OwnVehicle::find_own_cells(const LidarScan& scan) {
  const std::vector<Run> runs = all_runs(scan);
  DisjointSets bodies = bodies_of(runs);
  std::vector<int> excess(runs.size());  // of each body: cells of free runs less those of others
  const auto excess_of = [&](std::size_t run) -> int& {
    return excess[static_cast<std::size_t>(bodies.find(static_cast<std::int32_t>(run)))];
  };
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const int cells = static_cast<int>(runs[k].columns.size());
    excess_of(k) += runs[k].ends_freely ? cells : -cells;
  }
  own_.assign(cells_.size(), 0);
  near_own_.assign(cells_.size(), 0);
  any_own_ = false;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const int found = excess_of(k) < 0 ? -1 : 1;
    for (const int c : runs[k].columns) {
      Cell& cell = cells_[cell_index(runs[k].row, c)];
      cell.own = static_cast<std::int8_t>(std::clamp(cell.own + found, -kMostOwn, kMostOwn));
      if (cell.own <= 0) continue;
      any_own_ = true;
      own_[cell_index(runs[k].row, c)] = 1;
      const int last = std::min(c + kColumnsAside, model_->columns - 1);
      for (int near = std::max(c - kColumnsAside, 0); near <= last; ++near)
        near_own_[cell_index(runs[k].row, near)] = 1;
    }
  }
}

// Columns of the runs of constant cells of a row, each in the order of the columns, the last of which is
// followed by the first. A run goes on over up to kMostBridged others, with those that no range speaks
// against, and ends where the range changes by more than kLinked_m: flat ground beside the own vehicle is
// constant, too.
std::vector<std::vector<int>> OwnVehicle::constant_runs(int row) const {
  const auto range_m = [&](int c) { return cells_[cell_index(row, c)].range_m; };
  const int columns = model_->columns;
  std::vector<std::vector<int>> runs;
  const auto follows = [&](int last, int c) {
    return (c - last + columns) % columns <= kMostBridged + 1 &&
           std::abs(range_m(c) - range_m(last)) <= kLinked_m;
  };
  // Appends the cells from the end of the run to c that nothing speaks against, without c.
  const auto bridge = [&](std::vector<int>& run, int c) {
    const float last_m = range_m(run.back());
    for (int between = (run.back() + 1) % columns; between != c; between = (between + 1) % columns) {
      const Cell& cell = cells_[cell_index(row, between)];
      if (cell.same > 0 && cell.others == 0 && std::abs(cell.range_m - last_m) <= kLinked_m)
        run.push_back(between);
    }
  };
  for (int c = 0; c < columns; ++c) {
    if (!cells_[cell_index(row, c)].constant(key_scans_)) continue;
    if (runs.empty() || !follows(runs.back().back(), c)) {
      runs.emplace_back();
    } else {
      bridge(runs.back(), c);
    }
    runs.back().push_back(c);
  }
  if (runs.size() > 1 && follows(runs.back().back(), runs.front().front())) {
    bridge(runs.back(), runs.front().front());
    runs.back().insert(runs.back().end(), runs.front().begin(), runs.front().end());
    runs.erase(runs.begin());
  }
  return runs;
}

bool OwnVehicle::ends_freely(const LidarScan& scan, int row, int column, int side) const {
  const float range_m = cells_[cell_index(row, column)].range_m;
  int linked = 0;
  for (int k = 1; k <= kBeyondEnd; ++k) {
    const int c = (column + side * k + model_->columns) % model_->columns;
    const std::int32_t i = c < scan.columns ? scan.cell(row, c) : -1;
    if (i >= 0 && std::abs(scan.returns[static_cast<std::size_t>(i)].range_m - range_m) <= kLinked_m)
      ++linked;
    const Cell& beyond = cells_[cell_index(row, c)];
    const bool was_linked = beyond.others > 0 && std::abs(beyond.range_m - range_m) <= kLinked_m;
    const int remembered = std::min(key_scans_, kRemembered / 2);
    if (k > 1 && was_linked && 10 * beyond.same > kEndedPerTen * remembered) return false;
  }
  return 2 * linked <= kBeyondEnd;
}

void OwnVehicle::learn(const LidarScan& scan, const SE3& T_v0, double tolerance_m) {
  if (!is_key_scan(T_v0)) return;
  count_ranges(scan, static_cast<float>(tolerance_m));
  find_own_cells(scan);
}

std::vector<std::int32_t> OwnVehicle::find(const LidarScan& scan, double tolerance_m) const {
  const auto tolerance = static_cast<float>(tolerance_m);
  std::vector<std::int32_t> found;
  if (model_ != scan.model || !any_own_) return found;
  const auto is_own = [&](const LidarReturn& r) {
    const int last = std::min(r.column + kColumnsAside, model_->columns - 1);
    for (int c = std::max(r.column - kColumnsAside, 0); c <= last; ++c) {
      const std::size_t at = cell_index(r.laser, c);
      if (own_[at] != 0 && std::abs(r.range_m - cells_[at].range_m) <= tolerance) return true;
    }
    return false;
  };
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const int column = std::min(r.column, model_->columns - 1);
    if (r.range_m < kLargestRange_m && near_own_[cell_index(r.laser, column)] != 0 && is_own(r))
      found.push_back(static_cast<std::int32_t>(i));
  }
  return found;
}

}  // namespace mapless
