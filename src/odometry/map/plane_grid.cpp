#include "odometry/map/plane_grid.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// A plane is fitted again once the number of its points has grown by this factor. Chosen: 14 fits from 6 to
// 120 points, in between which the plane is at most a quarter more uncertain than its points would make it.
constexpr double kRefitGrowth = 1.25;
// Prefetching of memory, which changes no result: runs of points whose slots are fetched together, and runs
// whose cubes are fetched ahead. Chosen: more than the latency of memory needs, fewer than the first-level
// cache holds.
constexpr std::size_t kLookupBatch = 64;
constexpr std::size_t kPrefetchRuns = 8;

}  // namespace

void PlaneGrid::clear() {
  cubes_.clear();
  planes_.clear();
  table_.clear();
}

// Number of the cube of `key`, created if it does not exist, and prefetched; -1 if it is full.
std::int32_t PlaneGrid::open_cube(std::uint64_t key) {
  if (key == kNoCube) return -1;
  CubeTable::Slot& slot = table_.slot_of(key);
  if (slot.full) return -1;
  std::int32_t cube = slot.cube;
  if (cube < 0) {
    cube = static_cast<std::int32_t>(cubes_.size());
    cubes_.emplace_back().key = key;
    planes_.emplace_back();
    table_.add(slot, {key, cube});
  }
  __builtin_prefetch(&cubes_[static_cast<std::size_t>(cube)], 1);
  return cube;
}

void PlaneGrid::find_cubes(std::span<Run> runs) {
  for (Run& run : runs) run.cube = open_cube(run.key);
  for (const Run& run : runs) {
    if (run.cube < 0) continue;
    cubes_[static_cast<std::size_t>(run.cube)].pending += run.count;
  }
}

void PlaneGrid::find_runs(std::span<const MapPoint> points, double max_range_m) {
  std::size_t found = 0;
  std::uint64_t last = kNoCube;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const MapPoint& point = points[i];
    const CubePlace place = point.range_m > max_range_m ? CubePlace{} : place_of(point.p_0);
    const bool continues = place.key == last;
    last = place.key;
    if (last == kNoCube) continue;
    if (continues) {
      ++runs_.back().count;
      continue;
    }
    if (runs_.size() - found >= kLookupBatch) {
      find_cubes(std::span(runs_).subspan(found));
      found = runs_.size();
    }
    runs_.push_back({place.key, i, 1});
    fetch_slot(place);
  }
  find_cubes(std::span(runs_).subspan(found));
  std::erase_if(runs_, [](const Run& run) { return run.cube < 0; });
}

// The cube of a run may lie anywhere in memory: it is prefetched some runs ahead.
void PlaneGrid::insert(std::span<const MapPoint> points, double max_range_m, unsigned bit,
                       std::vector<unsigned>& grids) {
  find_runs(points, max_range_m);
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const Cube& later =
        cubes_[static_cast<std::size_t>(runs_[std::min(r + kPrefetchRuns, runs_.size() - 1)].cube)];
    __builtin_prefetch(&later, 1);
    __builtin_prefetch(&later.sums.products.back(), 1);  // often on another cache line
    const Run& run = runs_[r];
    Cube& cube = cubes_[static_cast<std::size_t>(run.cube)];
    if (cube.pending <= static_cast<std::uint32_t>(kMaxPoints - cube.sums.count)) {
      cube.pending -= run.count;
      add_run(points, run, bit, grids);
    } else {
      for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i)
        contested_.push_back({i, static_cast<std::uint32_t>(run.cube)});
    }
  }
  add_contested(points, bit, grids);
  runs_.clear();
  fit_planes();
}

// Points of cubes without room for all of them, sorted by pass (counting sort, stable).
void PlaneGrid::add_contested(std::span<const MapPoint> points, unsigned bit, std::vector<unsigned>& grids) {
  std::vector<std::size_t> next;  // where the next point of each pass goes
  for (const Contested& one : contested_) {
    const std::size_t pass = points[one.point].pass;
    if (next.size() < pass + 2) next.resize(pass + 2, 0);
    ++next[pass + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  contested_by_pass_.resize(contested_.size());
  for (const Contested& one : contested_) contested_by_pass_[next[points[one.point].pass]++] = one;
  for (const Contested& one : contested_by_pass_) {
    Cube& cube = cubes_[one.cube];
    cube.pending = 0;
    if (cube.sums.count < kMaxPoints)
      add_run(points, {cube.key, one.point, 1, static_cast<std::int32_t>(one.cube)}, bit, grids);
  }
  contested_.clear();
  contested_by_pass_.clear();
}

void PlaneGrid::add_run(std::span<const MapPoint> points, const Run& run, unsigned bit,
                        std::vector<unsigned>& grids) {
  const auto number = static_cast<std::size_t>(run.cube);
  Cube& cube = cubes_[number];
  const Vector3d corner_0 = lattice_.corner_of(run.key);
  PointSums sums = cube.sums;  // in registers
  const bool was_spanned = cube.spanned;
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
    const MapPoint& point = points[i];
    sums.add(point.p_0[0] - corner_0[0], point.p_0[1] - corner_0[1], point.p_0[2] - corner_0[2]);
    const std::uint64_t laser = std::uint64_t{1} << (point.laser & 63U);
    cube.lasers_of_scan = cube.scan == point.scan ? cube.lasers_of_scan | laser : laser;
    cube.scan = point.scan;
    cube.lasers |= laser;
    cube.spanned = cube.spanned || cube.lasers_of_scan != laser;
    grids[i] |= bit;
  }
  cube.sums = sums;
  if (sums.count >= kMaxPoints) table_.slot_of(cube.key).full = true;
  if (!cube.refit_pending && sums.count >= kMinPlanePoints &&
      (sums.count >= kRefitGrowth * cube.fitted || cube.spanned != was_spanned)) {
    cube.refit_pending = true;
    grown_.push_back(static_cast<std::uint32_t>(number));
  }
}

void PlaneGrid::fit_planes() {
  for (const std::uint32_t i : grown_) {
    cubes_[i].refit_pending = false;
    if (std::popcount(cubes_[i].lasers) >= kMinPlaneLasers) fit(i);
  }
  grown_.clear();
}

void PlaneGrid::remove(const std::vector<Vector3d>& points_0) {
  std::vector<std::size_t> changed;
  for (const Vector3d& p_0 : points_0) {
    const CubePlace place = place_of(p_0);
    if (place.key == kNoCube) continue;
    CubeTable::Slot& slot = table_.slot_of(place.key);
    if (slot.cube < 0) continue;
    const auto i = static_cast<std::size_t>(slot.cube);
    if (cubes_[i].sums.count == 0) continue;
    const Vector3d p = p_0 - lattice_.corner_of(place.key);
    cubes_[i].sums.add(p[0], p[1], p[2], -1);
    slot.full = false;
    changed.push_back(i);
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  for (const std::size_t i : changed) fit(i);
}

void PlaneGrid::keep_within(const Vector3d& centre_0, double radius_m) {
  const auto far = [&](const Cube& cube) {
    return (lattice_.corner_of(cube.key) - centre_0).squaredNorm() > radius_m * radius_m;
  };
  table_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (far(cubes_[i])) continue;
    cubes_[kept] = cubes_[i];
    planes_[kept] = planes_[i];
    const std::uint64_t key = cubes_[kept].key;
    const bool full = cubes_[kept].sums.count >= kMaxPoints;
    table_.add(table_.slot_of(key), {key, static_cast<std::int32_t>(kept++), full});
  }
  cubes_.erase(cubes_.begin() + static_cast<std::ptrdiff_t>(kept), cubes_.end());
  planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(kept), planes_.end());
}

void PlaneGrid::fit(std::size_t i) {
  Cube& cube = cubes_[i];
  cube.fitted = cube.sums.count;
  const bool enough = std::popcount(cube.lasers) >= kMinPlaneLasers;
  planes_[i] = enough ? fit_plane(cube.sums, cube.spanned, lattice_.cube_m(), sigma_m_) : FittedPlane();
}

PlaneGrid::Candidate PlaneGrid::candidate_at(const Vector3d& q_0, const CubePlace& place) const {
  if (place.cube < 0) return {};
  const FittedPlane& plane = planes_[static_cast<std::size_t>(place.cube)];
  if (!plane.exists()) return {};
  return {place, plane.variance_at((q_0 - lattice_.corner_of(place.key)).cast<float>())};
}

MapPlane PlaneGrid::plane_of(const Candidate& candidate) const {
  const FittedPlane& plane = planes_[static_cast<std::size_t>(candidate.place.cube)];
  return plane.in_world(lattice_.corner_of(candidate.place.key), candidate.variance);
}

std::optional<MapPlane> PlaneGrid::plane_at(const Vector3d& q_0) const {
  CubePlace place = place_of(q_0);
  fetch_cube(place);
  const Candidate candidate = candidate_at(q_0, place);
  if (candidate.place.cube < 0) return std::nullopt;
  return plane_of(candidate);
}

}  // namespace mapless
