#include "odometry/plane_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "odometry/cube_hash.hpp"

namespace mapless {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFirstCapacity = 4096;
constexpr double kExpectedWeight = 6;  // the expected noise counts like so many points
constexpr double kFlat = 2.5;          // the plane extends so many times its thickness, squared
constexpr double kCutSigmas = 2.5;
// A plane is fitted anew when a cube has grown by this share.
constexpr double kGrowth = 1.25;
constexpr std::size_t kAhead = 12;  // points

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

std::int32_t PlaneGrid::find(std::uint64_t key) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = cube_slot(key, shift_);
  while (table_[slot].cube >= 0 && table_[slot].key != key) slot = (slot + 1) & mask;
  return table_[slot].cube;
}

std::size_t PlaneGrid::find_or_add(std::uint64_t key) {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = cube_slot(key, shift_);
  while (table_[slot].cube >= 0 && table_[slot].key != key) slot = (slot + 1) & mask;
  if (table_[slot].cube >= 0) return static_cast<std::size_t>(table_[slot].cube);
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
    table_[slot] = {cubes_[i].key, static_cast<std::int32_t>(i)};
  }
}

void PlaneGrid::add(Cube& cube, const Vector3d& offset, double sign) const {
  cube.count = static_cast<std::int16_t>(cube.count + (sign > 0 ? 1 : -1));
  const Vector3d signed_offset = sign * offset;
  cube.sum += signed_offset;
  std::size_t k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) cube.products[k++] += signed_offset[i] * offset[j];
}

PlaneGrid::Place PlaneGrid::place_of(const Vector3d& p_0) const {
  const Vector3d p = from_origin(p_0);
  return {has_cube(p, cube_m_) ? cube_key(cube_of(p, cubes_per_m_)) : kNowhere};
}

void PlaneGrid::fetch_cube(const Place& place) const {
  if (place.key == kNowhere) return;
  const std::int32_t cube = table_[cube_slot(place.key, shift_)].cube;
  if (cube < 0) return;
  const Cube* at = &cubes_[static_cast<std::size_t>(cube)];
  __builtin_prefetch(at, 1);
  __builtin_prefetch(&at->products.back(), 1);  // often in another line of the cache
}

// What a point needs lies anywhere in memory, and is asked for some points ahead.
void PlaneGrid::insert(const std::vector<MapPoint>& points, double farthest_m, unsigned bit,
                       std::vector<unsigned>& taken) {
  std::vector<Place> places(points.size());
  for (std::size_t i = 0; i < points.size() + 2 * kAhead; ++i) {
    if (i < points.size()) {
      places[i] = points[i].range_m > farthest_m ? Place{kNowhere} : place_of(points[i].p_0);
      fetch_slot(places[i]);
    }
    if (i >= kAhead && i - kAhead < points.size()) fetch_cube(places[i - kAhead]);
    if (i >= 2 * kAhead && insert(points[i - 2 * kAhead], places[i - 2 * kAhead]))
      taken[i - 2 * kAhead] |= bit;
  }
  fit_planes();
}

bool PlaneGrid::insert(const MapPoint& point, const Place& place) {
  if (place.key == kNowhere) return false;
  const std::size_t i = find_or_add(place.key);
  Cube& cube = cubes_[i];
  if (cube.count >= kFull) return false;
  add(cube, from_origin(point.p_0) - cube_m_ * cube_of_key(place.key).cast<double>().matrix(), 1);
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

void PlaneGrid::remove(const Vector3d& p_0) {
  const Place place = place_of(p_0);
  const std::int32_t found = place.key == kNowhere ? -1 : find(place.key);
  if (found < 0) return;
  const auto i = static_cast<std::size_t>(found);
  Cube& cube = cubes_[i];
  if (cube.count == 0) return;
  add(cube, from_origin(p_0) - cube_m_ * cube_of_key(place.key).cast<double>().matrix(), -1);
  fit(i);
}

void PlaneGrid::keep_within(const Vector3d& centre_0, double radius_m) {
  const Vector3d centre = from_origin(centre_0);
  const auto far = [&](const Cube& cube) {
    return (cube_m_ * cube_of_key(cube.key).cast<double>().matrix() - centre).squaredNorm() >
           radius_m * radius_m;
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

void PlaneGrid::fetch_slot(const Place& place) const {
  if (place.key != kNowhere) __builtin_prefetch(&table_[cube_slot(place.key, shift_)]);
}

void PlaneGrid::fetch_plane(const Place& place) const {
  if (place.key == kNowhere) return;
  const std::int32_t cube = table_[cube_slot(place.key, shift_)].cube;
  if (cube >= 0) __builtin_prefetch(&planes_[static_cast<std::size_t>(cube)]);
}

std::optional<MapPlane> PlaneGrid::plane_at(const Vector3d& q_0, const Place& place) const {
  if (place.key == kNowhere) return std::nullopt;
  const std::int32_t found = find(place.key);
  if (found < 0) return std::nullopt;
  const Plane& plane = planes_[static_cast<std::size_t>(found)];
  if (plane.uncertainty <= 0) return std::nullopt;
  const Vector3d corner = cube_m_ * cube_of_key(place.key).cast<double>().matrix();
  const Eigen::Vector3f d = (from_origin(q_0) - corner).cast<float>() - plane.mean;
  const float along_middle = d.dot(plane.middle);
  const float across = d.dot(plane.normal);
  const float along_largest_squared =
      std::max(0.F, d.squaredNorm() - along_middle * along_middle - across * across);
  const float variance = plane.thickness + plane.uncertainty +
                         plane.per_middle * along_middle * along_middle +
                         plane.per_largest * along_largest_squared;
  return MapPlane{(corner + plane.mean.cast<double>()).array() + offset_m_, plane.normal.cast<double>(),
                  variance, (plane.per_middle + plane.per_largest) / 2};
}

}  // namespace mapless
