#include "odometry/plane_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace mapless {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFirstCapacity = 4096;
constexpr double kExpectedWeight = 6;  // the expected noise counts like so many points
constexpr double kFlat = 2.5;          // the plane extends so many times its thickness, squared
constexpr double kCutSigmas = 2.5;
// A plane is fitted anew when a cube has grown by this share.
constexpr double kGrowth = 1.25;
constexpr std::size_t kAtOnce = 64;  // points whose cubes are fetched together

}  // namespace

PlaneGrid::PlaneGrid(double cube_m, double offset_m, double sigma_m)
    : cube_m_(cube_m), cubes_per_m_(1 / cube_m), offset_m_(offset_m), sigma_m_(sigma_m) {
  rebuild_table(kFirstCapacity);
}

void PlaneGrid::clear() {
  cubes_.clear();
  planes_.clear();
  rebuild_table(kFirstCapacity);
}

Vector3d PlaneGrid::from_origin(const Vector3d& p_0) const { return (p_0.array() - offset_m_).matrix(); }

Vector3d PlaneGrid::corner_of(std::uint64_t key) const {
  return {cube_m_ * cube_begin(key, 0), cube_m_ * cube_begin(key, 1), cube_m_ * cube_begin(key, 2)};
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
    table_[slot] = {cubes_[i].key, static_cast<std::int32_t>(i), cubes_[i].count >= kFull};
  }
}

// Axis by axis: vectors on their way through memory would keep one another waiting.
void PlaneGrid::add(Cube& cube, const Vector3d& p_0, int sign) const {
  const auto offset = [&](int axis) { return p_0[axis] - offset_m_ - cube_m_ * cube_begin(cube.key, axis); };
  const double x = offset(0), y = offset(1), z = offset(2);
  const double sx = sign * x, sy = sign * y, sz = sign * z;
  cube.count = static_cast<std::int16_t>(cube.count + sign);
  cube.sum[0] += sx;
  cube.sum[1] += sy;
  cube.sum[2] += sz;
  cube.products[0] += sx * x;
  cube.products[1] += sx * y;
  cube.products[2] += sx * z;
  cube.products[3] += sy * y;
  cube.products[4] += sy * z;
  cube.products[5] += sz * z;
}

// Where the cube can take more: fetched. -1 otherwise.
std::int32_t PlaneGrid::open_cube(const Place& place) {
  if (place.key == kNowhere) return -1;
  const std::size_t slot = slot_of(place.key);
  const bool known = table_[slot].cube >= 0;
  if (known && table_[slot].full) return -1;
  const std::size_t i = known ? static_cast<std::size_t>(table_[slot].cube) : add_cube(slot, place.key);
  __builtin_prefetch(&cubes_[i], 1);
  __builtin_prefetch(&cubes_[i].products.back(), 1);  // often in another line of the cache
  return static_cast<std::int32_t>(i);
}

// What a point needs lies anywhere in memory, and is asked for before others are seen to.
void PlaneGrid::insert(const std::vector<MapPoint>& points, double farthest_m, unsigned bit,
                       std::vector<unsigned>& taken) {
  std::array<Place, kAtOnce> places;
  std::array<std::int32_t, kAtOnce> cubes;
  for (std::size_t first = 0; first < points.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, points.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      const MapPoint& point = points[first + k];
      places[k] = point.range_m > farthest_m ? Place{kNowhere} : place_of(point.p_0);
      fetch_slot(places[k]);
    }
    for (std::size_t k = 0; k < count; ++k) cubes[k] = open_cube(places[k]);
    for (std::size_t k = 0; k < count; ++k) {
      if (cubes[k] >= 0 && insert(points[first + k], static_cast<std::size_t>(cubes[k])))
        taken[first + k] |= bit;
    }
  }
  fit_planes();
}

bool PlaneGrid::insert(const MapPoint& point, std::size_t i) {
  Cube& cube = cubes_[i];
  if (cube.count >= kFull) return false;  // since it was found open
  add(cube, point.p_0, 1);
  if (cube.count >= kFull) table_[slot_of(cube.key)].full = true;
  cube.lines |= std::uint64_t{1} << (point.line & 63U);
  if (!cube.waits && cube.count >= kFewest && cube.count >= kGrowth * cube.fitted) {
    cube.waits = true;
    grown_.push_back(static_cast<std::uint32_t>(i));
  }
  return true;
}

void PlaneGrid::fit_planes() {
  for (const std::uint32_t i : grown_) {
    cubes_[i].waits = false;
    if (std::popcount(cubes_[i].lines) >= kFewestLines) fit(i);
  }
  grown_.clear();
}

void PlaneGrid::remove(const std::vector<Vector3d>& points_0) {
  std::vector<std::size_t> changed;
  for (const Vector3d& p_0 : points_0) {
    const Place place = place_of(p_0);
    if (place.key == kNowhere) continue;
    Slot& slot = table_[slot_of(place.key)];
    if (slot.cube < 0) continue;
    const auto i = static_cast<std::size_t>(slot.cube);
    if (cubes_[i].count == 0) continue;
    add(cubes_[i], p_0, -1);
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
  if (cube.count < kFewest || std::popcount(cube.lines) < kFewestLines) return;
  const double n = cube.count;
  const Vector3d mean = cube.sum / n;
  Eigen::Matrix3d scatter;
  const auto& s = cube.products;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  scatter = (scatter / n - mean * mean.transpose()).eval();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Vector3d extent = solver.eigenvalues().cwiseMax(0);
  // Three of the points' freedoms went into the plane.
  const double thickness =
      (n * extent[0] + kExpectedWeight * sigma_m_ * sigma_m_) / (n - 3 + kExpectedWeight);
  if (extent[1] < kFlat * thickness) return;
  Plane plane;
  plane.mean = mean.cast<float>();
  plane.normal = solver.eigenvectors().col(0).cast<float>();
  plane.middle = solver.eigenvectors().col(1).cast<float>();
  if (is_cut(plane)) return;
  plane.thickness = static_cast<float>(thickness);
  const double uncertainty = thickness / n;
  plane.uncertainty = static_cast<float>(uncertainty);
  plane.per_middle = static_cast<float>(uncertainty / extent[1]);
  plane.per_largest = static_cast<float>(uncertainty / extent[2]);
  planes_[i] = plane;
}

// A face of the cube that is nearly parallel to the plane and close to it parts the points by their noise:
// what is left lies on one side of the surface.
bool PlaneGrid::is_cut(const Plane& plane) const {
  Eigen::Index axis = 0;
  const double across = plane.normal.cwiseAbs().maxCoeff(&axis);
  const double from_face = std::min<double>(plane.mean[axis], cube_m_ - plane.mean[axis]);
  return from_face * across < kCutSigmas * sigma_m_;
}

void PlaneGrid::fetch_plane(const Place& place) const {
  if (place.key == kNowhere) return;
  const std::int32_t cube = table_[cube_slot(place.key, shift_)].cube;
  if (cube >= 0) __builtin_prefetch(&planes_[static_cast<std::size_t>(cube)]);
}

PlaneGrid::Candidate PlaneGrid::candidate_at(const Vector3d& q_0, const Place& place) const {
  if (place.key == kNowhere) return {};
  const std::int32_t cube = table_[slot_of(place.key)].cube;
  if (cube < 0) return {};
  const Plane& plane = planes_[static_cast<std::size_t>(cube)];
  if (plane.uncertainty <= 0) return {};
  const Eigen::Vector3f d = (from_origin(q_0) - corner_of(place.key)).cast<float>() - plane.mean;
  const float along_middle = d.dot(plane.middle);
  const float across = d.dot(plane.normal);
  const float along_largest_squared =
      std::max(0.F, d.squaredNorm() - along_middle * along_middle - across * across);
  return {place, cube,
          plane.thickness + plane.uncertainty + plane.per_middle * along_middle * along_middle +
              plane.per_largest * along_largest_squared};
}

MapPlane PlaneGrid::plane_of(const Candidate& candidate) const {
  const Plane& plane = planes_[static_cast<std::size_t>(candidate.cube)];
  return {(corner_of(candidate.place.key) + plane.mean.cast<double>()).array() + offset_m_,
          plane.normal.cast<double>(), candidate.variance, (plane.per_middle + plane.per_largest) / 2};
}

double PlaneGrid::from_face(const Vector3d& p_0) const {
  double least = 0.5;
  for (const double p : {p_0.x(), p_0.y(), p_0.z()}) {
    const double at = in_cubes(p);
    const double over = std::abs(at - static_cast<double>(static_cast<std::int64_t>(at)));
    least = std::min({least, over, 1 - over});
  }
  return cube_m_ * least;
}

std::optional<MapPlane> PlaneGrid::plane_at(const Vector3d& q_0) const {
  const Candidate candidate = candidate_at(q_0, place_of(q_0));
  if (candidate.cube < 0) return std::nullopt;
  return plane_of(candidate);
}

}  // namespace mapless
