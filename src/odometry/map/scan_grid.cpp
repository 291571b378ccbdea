#include "odometry/map/scan_grid.hpp"

#include <array>
#include <bit>

namespace mapless::inline v1 {
namespace {

// Runs whose slots, and then parts, are fetched together. Chosen: more than the latency of memory needs,
// fewer than the first-level cache holds; changes no result.
constexpr std::size_t kBatch = 64;

bool is_spanned(std::uint64_t lasers) { return std::popcount(lasers) >= kMinPlaneLasers; }

}  // namespace

void ScanGrid::clear() {
  table_.clear();
  cubes_.clear();
  parts_.clear();
  scans_ = 0;
}

std::int32_t ScanGrid::cube_of(std::uint64_t key) {
  CubeTable::Slot& slot = table_.slot_of(key);
  if (slot.cube >= 0) return slot.cube;
  const auto cube = static_cast<std::int32_t>(cubes_.size());
  cubes_.emplace_back().key = key;
  table_.add(slot, {key, cube});
  return cube;
}

// The part of the newest scan, created if there is none.
std::size_t ScanGrid::part_of(std::int32_t cube) {
  std::vector<std::int32_t>& parts = parts_of_[scans_ - 1];
  if (parts.size() < cubes_.size()) parts.resize(cubes_.size(), -1);
  std::int32_t& part = parts[static_cast<std::size_t>(cube)];
  if (part < 0) {
    part = static_cast<std::int32_t>(parts_.size());
    parts_.push_back({cube, 0, {}});
  }
  return static_cast<std::size_t>(part);
}

void ScanGrid::add_runs(std::span<const MapPoint> points, std::span<const Run> runs) {
  std::array<std::size_t, kBatch> parts{};
  for (std::size_t r = 0; r < runs.size(); ++r) {
    parts[r] = part_of(cube_of(runs[r].key));
    __builtin_prefetch(&parts_[parts[r]], 1);
  }
  for (std::size_t r = 0; r < runs.size(); ++r) {
    Part& part = parts_[parts[r]];
    const Eigen::Vector3d corner_0 = lattice_.corner_of(runs[r].key);
    PointSums sums = part.sums;  // in registers
    for (const MapPoint& point : points.subspan(runs[r].begin, runs[r].count)) {
      sums.add(point.p_0[0] - corner_0[0], point.p_0[1] - corner_0[1], point.p_0[2] - corner_0[2]);
      part.lasers |= std::uint64_t{1} << (point.laser & 63U);
    }
    part.sums = sums;
  }
}

void ScanGrid::add_scan(std::span<const MapPoint> points, double max_range_m) {
  if (parts_of_.size() <= scans_) parts_of_.emplace_back();
  parts_of_[scans_++].clear();
  const std::size_t first_part = parts_.size();
  std::array<Run, kBatch> runs{};
  std::size_t count = 0;
  std::uint64_t last = kNoCube;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::uint64_t key = points[i].range_m > max_range_m ? kNoCube : lattice_.key_of(points[i].p_0);
    const bool continues = key == last;
    last = key;
    if (key == kNoCube) continue;
    if (continues) {
      ++runs[count - 1].count;
      continue;
    }
    if (count == kBatch) {
      add_runs(points, runs);
      count = 0;
    }
    runs[count++] = {key, i, 1};
    table_.prefetch(key);
  }
  add_runs(points, std::span(runs).first(count));
  for (const Part& part : std::span(parts_).subspan(first_part)) {
    Cube& cube = cubes_[static_cast<std::size_t>(part.cube)];
    cube.shared_lasers |= cube.lasers & part.lasers;
    cube.lasers |= part.lasers;
    cube.spanned_parts += is_spanned(part.lasers) ? 1 : 0;
    cube.sums.add(part.sums);
  }
}

const ScanGrid::Part* ScanGrid::find_part(std::size_t scan, std::size_t cube) const {
  if (scan >= scans_ || cube >= parts_of_[scan].size() || parts_of_[scan][cube] < 0) return nullptr;
  return &parts_[static_cast<std::size_t>(parts_of_[scan][cube])];
}

ScanGrid::Others::Candidate ScanGrid::Others::candidate_at(const Eigen::Vector3d& q_0,
                                                           const CubePlace& place) const {
  if (place.cube < 0) return {};
  const auto number = static_cast<std::size_t>(place.cube);
  const Cube& cube = grid_->cubes_[number];
  if (cube.sums.count < kMinPlanePoints) return {};
  PointSums sums = cube.sums;
  std::uint64_t lasers = cube.lasers;
  int spanned_parts = cube.spanned_parts;
  if (const Part* own = grid_->find_part(scan_, number)) {
    sums.add(own->sums, -1);
    lasers &= ~own->lasers | cube.shared_lasers;
    spanned_parts -= is_spanned(own->lasers) ? 1 : 0;
  }
  if (std::popcount(lasers) < kMinPlaneLasers) return {};
  const FittedPlane plane = fit_plane(sums, spanned_parts > 0, grid_->lattice_.cube_m(), grid_->sigma_m_);
  if (!plane.exists()) return {};
  return {plane.variance_at((q_0 - grid_->lattice_.corner_of(cube.key)).cast<float>()), cube.key, plane};
}

}  // namespace mapless
