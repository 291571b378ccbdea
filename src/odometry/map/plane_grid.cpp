#include "odometry/map/plane_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// Slots of an empty table; it doubles when half full. Chosen: 64 kB; affects speed alone.
constexpr std::size_t kInitialSlots = 4096;
// Weight, in points, of the expected noise in the thickness of a plane. Chosen: as many as the fewest points
// of a plane, because a plane of a few scan lines looks far thinner than it is (method.md section 6, "Map").
constexpr double kNoisePriorPoints = 6;
// Fewest times its thickness that a plane's medium extent must be (both are variances, [m^2]): points on a
// line, or scattered in all directions, have no normal. Chosen: 1.6 times in length; scattered points have
// about 1.
constexpr double kMinFlatness = 2.5;
// Lines that lasers draw in different scans lie as the motion estimated between these scans puts them: when a
// sensor on its side turns by two laser spacings a scan, the lines of one laser fall on those of another, and
// the map confirms that turn though the true one is faster. A plane that no scan has hit with two lasers is
// therefore uncertain by this much more, and there is none where the points are rougher than so many times
// the noise: in a tree any lines make one. Chosen: the error of the motion of a scan that still counts as
// right (.2 m over four scans), and kGoodSigmas of PlaneMap. Measured (docs/notebook/odometry.md, "Lines of
// different scans"): of 44 VLP-16 recordings 27 windows of four scans err by more than .5 m without, 2 with;
// with .1 m 2, without the second rule 11, without any such plane motorways are lost.
constexpr double kSweptSigma_m = 0.05;
constexpr double kSweptSmoothness = 1.5;
// Distance of a plane from a parallel face of its cube, in standard deviations of the noise: 99 % of the
// points of the surface then lie in the cube.
constexpr double kMinFaceDistanceSigmas = 2.5;
// A plane is fitted again once the number of its points has grown by this factor. Chosen: 14 fits from 6 to
// 120 points, in between which the plane is at most a quarter more uncertain than its points would make it.
constexpr double kRefitGrowth = 1.25;
// Prefetching of memory, which changes no result: runs of points whose slots are fetched together, and runs
// whose cubes are fetched ahead. Chosen: more than the latency of memory needs, fewer than the first-level
// cache holds.
constexpr std::size_t kLookupBatch = 64;
constexpr std::size_t kPrefetchRuns = 8;

}  // namespace

PlaneGrid::PlaneGrid(double cube_m, double offset_m, double sigma_m)
    : cube_m_(cube_m),
      cubes_per_m_(1 / cube_m),
      offset_m_(offset_m),
      middle_m_(offset_m + cube_m / 2),
      sigma_m_(sigma_m) {
  rebuild_table(kInitialSlots);
}

void PlaneGrid::clear() {
  cubes_.clear();
  planes_.clear();
  rebuild_table(table_.size());
}

Vector3d PlaneGrid::from_origin(const Vector3d& p_0) const { return (p_0.array() - offset_m_).matrix(); }

Vector3d PlaneGrid::corner_of(std::uint64_t key) const {
  return {cube_m_ * cube_number(key, 0), cube_m_ * cube_number(key, 1), cube_m_ * cube_number(key, 2)};
}

std::size_t PlaneGrid::add_cube(std::size_t slot, std::uint64_t key) {
  table_[slot] = {key, static_cast<std::int32_t>(cubes_.size())};
  cubes_.emplace_back().key = key;
  planes_.emplace_back();
  if (2 * cubes_.size() > table_.size()) rebuild_table(2 * table_.size());
  return cubes_.size() - 1;
}

void PlaneGrid::rebuild_table(std::size_t capacity) {
  table_.assign(capacity, {});
  shift_ = 64 - std::countr_zero(capacity);
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    std::size_t slot = cube_slot(cubes_[i].key, shift_);
    while (table_[slot].cube >= 0) slot = (slot + 1) & (capacity - 1);
    table_[slot] = {cubes_[i].key, static_cast<std::int32_t>(i), cubes_[i].count >= kMaxPoints};
  }
}

// Axis by axis, in registers: with Eigen vectors each sum would pass through memory.
void PlaneGrid::Sums::add(double x, double y, double z, int sign) {
  const double sx = sign * x, sy = sign * y, sz = sign * z;
  first[0] += sx;
  first[1] += sy;
  first[2] += sz;
  products[0] += sx * x;
  products[1] += sx * y;
  products[2] += sx * z;
  products[3] += sy * y;
  products[4] += sy * z;
  products[5] += sz * z;
}

// Number of the cube of `key`, created if it does not exist, and prefetched; -1 if it is full.
std::int32_t PlaneGrid::open_cube(std::uint64_t key) {
  if (key == kNoCube) return -1;
  const std::size_t slot = slot_of(key);
  const bool exists = table_[slot].cube >= 0;
  if (exists && table_[slot].full) return -1;
  const std::size_t i = exists ? static_cast<std::size_t>(table_[slot].cube) : add_cube(slot, key);
  __builtin_prefetch(&cubes_[i], 1);
  return static_cast<std::int32_t>(i);
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
    const Place place = point.range_m > max_range_m ? Place{kNoCube} : place_of(point.p_0);
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
    if (cube.pending <= static_cast<std::uint32_t>(kMaxPoints - cube.count)) {
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
    if (cube.count < kMaxPoints)
      add_run(points, {cube.key, one.point, 1, static_cast<std::int32_t>(one.cube)}, bit, grids);
  }
  contested_.clear();
  contested_by_pass_.clear();
}

void PlaneGrid::add_run(std::span<const MapPoint> points, const Run& run, unsigned bit,
                        std::vector<unsigned>& grids) {
  const auto number = static_cast<std::size_t>(run.cube);
  Cube& cube = cubes_[number];
  const Vector3d corner_0 = corner_of(run.key).array() + offset_m_;
  Sums sums = cube.sums;  // in registers
  const bool was_spanned = cube.spanned;
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
    const MapPoint& point = points[i];
    sums.add(point.p_0[0] - corner_0[0], point.p_0[1] - corner_0[1], point.p_0[2] - corner_0[2], 1);
    const std::uint64_t laser = std::uint64_t{1} << (point.laser & 63U);
    cube.lasers_of_scan = cube.scan == point.scan ? cube.lasers_of_scan | laser : laser;
    cube.scan = point.scan;
    cube.lasers |= laser;
    cube.spanned = cube.spanned || cube.lasers_of_scan != laser;
    grids[i] |= bit;
  }
  cube.sums = sums;
  cube.count = static_cast<std::int16_t>(cube.count + static_cast<int>(run.count));
  if (cube.count >= kMaxPoints) table_[slot_of(cube.key)].full = true;
  if (!cube.refit_pending && cube.count >= kMinPoints &&
      (cube.count >= kRefitGrowth * cube.fitted || cube.spanned != was_spanned)) {
    cube.refit_pending = true;
    grown_.push_back(static_cast<std::uint32_t>(number));
  }
}

void PlaneGrid::fit_planes() {
  for (const std::uint32_t i : grown_) {
    cubes_[i].refit_pending = false;
    if (std::popcount(cubes_[i].lasers) >= kMinLasers) fit(i);
  }
  grown_.clear();
}

void PlaneGrid::remove(const std::vector<Vector3d>& points_0) {
  std::vector<std::size_t> changed;
  for (const Vector3d& p_0 : points_0) {
    const Place place = place_of(p_0);
    if (place.key == kNoCube) continue;
    Slot& slot = table_[slot_of(place.key)];
    if (slot.cube < 0) continue;
    const auto i = static_cast<std::size_t>(slot.cube);
    if (cubes_[i].count == 0) continue;
    const Vector3d p = from_origin(p_0) - corner_of(place.key);
    cubes_[i].sums.add(p[0], p[1], p[2], -1);
    --cubes_[i].count;
    slot.full = false;
    changed.push_back(i);
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  for (const std::size_t i : changed) fit(i);
}

void PlaneGrid::keep_within(const Vector3d& centre_0, double radius_m) {
  const Vector3d centre = from_origin(centre_0);
  const auto far = [&](const Cube& cube) {
    return (corner_of(cube.key) - centre).squaredNorm() > radius_m * radius_m;
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (far(cubes_[i])) continue;
    cubes_[kept] = cubes_[i];
    planes_[kept++] = planes_[i];
  }
  cubes_.erase(cubes_.begin() + static_cast<std::ptrdiff_t>(kept), cubes_.end());
  planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(kept), planes_.end());
  rebuild_table(table_.size());
}

void PlaneGrid::fit(std::size_t i) {
  Cube& cube = cubes_[i];
  cube.fitted = cube.count;
  planes_[i] = {};
  if (cube.count < kMinPoints || std::popcount(cube.lasers) < kMinLasers) return;
  const double n = cube.count;
  const Vector3d mean = Eigen::Map<const Vector3d>(cube.sums.first.data()) / n;
  Eigen::Matrix3d scatter;
  const auto& s = cube.sums.products;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  scatter = (scatter / n - mean * mean.transpose()).eval();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Vector3d extent = solver.eigenvalues().cwiseMax(0);
  // The fit of the plane took 3 degrees of freedom.
  const double thickness =
      (n * extent[0] + kNoisePriorPoints * sigma_m_ * sigma_m_) / (n - 3 + kNoisePriorPoints);
  if (extent[1] < kMinFlatness * thickness) return;
  if (!cube.spanned && thickness > kSweptSmoothness * kSweptSmoothness * sigma_m_ * sigma_m_) return;
  Plane plane;
  plane.mean = mean.cast<float>();
  plane.normal = solver.eigenvectors().col(0).cast<float>();
  plane.middle = solver.eigenvectors().col(1).cast<float>();
  if (is_cut(plane)) return;
  plane.thickness = static_cast<float>(thickness + (cube.spanned ? 0 : kSweptSigma_m * kSweptSigma_m));
  const double uncertainty = thickness / n;
  plane.uncertainty = static_cast<float>(uncertainty);
  plane.per_middle = static_cast<float>(uncertainty / extent[1]);
  plane.per_largest = static_cast<float>(uncertainty / extent[2]);
  planes_[i] = plane;
}

// A face of the cube that is nearly parallel to the plane and close to it separates the points by their
// noise: the points left in the cube lie on one side of the surface.
bool PlaneGrid::is_cut(const Plane& plane) const {
  Eigen::Index axis = 0;
  const double across = plane.normal.cwiseAbs().maxCoeff(&axis);
  const double distance_to_face = std::min<double>(plane.mean[axis], cube_m_ - plane.mean[axis]);
  return distance_to_face * across < kMinFaceDistanceSigmas * sigma_m_;
}

PlaneGrid::Candidate PlaneGrid::candidate_at(const Vector3d& q_0, const Place& place) const {
  if (place.cube < 0) return {};
  const Plane& plane = planes_[static_cast<std::size_t>(place.cube)];
  if (plane.uncertainty <= 0) return {};
  const Eigen::Vector3f d = (from_origin(q_0) - corner_of(place.key)).cast<float>() - plane.mean;
  const float along_middle = d.dot(plane.middle);
  const float across = d.dot(plane.normal);
  const float along_largest_squared =
      std::max(0.F, d.squaredNorm() - along_middle * along_middle - across * across);
  return {place, plane.thickness + plane.uncertainty + plane.per_middle * along_middle * along_middle +
                     plane.per_largest * along_largest_squared};
}

MapPlane PlaneGrid::plane_of(const Candidate& candidate) const {
  const Plane& plane = planes_[static_cast<std::size_t>(candidate.place.cube)];
  return {(corner_of(candidate.place.key) + plane.mean.cast<double>()).array() + offset_m_,
          plane.normal.cast<double>(), candidate.variance, (plane.per_middle + plane.per_largest) / 2};
}

std::optional<MapPlane> PlaneGrid::plane_at(const Vector3d& q_0) const {
  Place place = place_of(q_0);
  fetch_plane(place);
  const Candidate candidate = candidate_at(q_0, place);
  if (candidate.place.cube < 0) return std::nullopt;
  return plane_of(candidate);
}

}  // namespace mapless
