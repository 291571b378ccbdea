#include "detection/tracking/completion/sliding_side.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3f;

// A door bulges by a few centimetres, and noise adds as much. Chosen.
constexpr float kThickness_m = 0.12F;
// Sine of the largest angle between plane and velocity: 30 degrees, for velocities known to 3 sigma.
constexpr float kMostAcross = 0.5F;
constexpr std::size_t kLeastOfObject = 8;  // of its points in the plane; chosen
// A wall or the ground goes on ahead of what moves along it; the side of a body does not, up to its noise.
constexpr float kAhead_m = 0.5F;
constexpr std::size_t kNear =
    600;  // points beside the object that show the plane; chosen for the time it takes
constexpr std::size_t kCounted = 150;  // of these
constexpr int kTriples = 40;  // of points, tried as planes: 0.3 of them in the plane are enough for 2 in 3
constexpr int kPlanes = 2;    // the ground beside a body may be larger than its side

constexpr float kFar_m = std::numeric_limits<float>::max();

bool runs_along(const SlidingSide& plane, const Vector3f& velocity) {
  return std::abs(plane.normal.dot(velocity)) <= kMostAcross * velocity.norm();
}

}  // namespace

SideSearch::SideSearch(const LidarScan& scan, const ObjectProposals& proposed,
                       const std::vector<TrackMotion>& motions, const std::vector<std::uint16_t>& object)
    : points_(proposed.points.points),
      votes_(proposed.votes),
      motions_(motions),
      object_(object),
      neighbours_(scan, proposed.points, proposed.parameters),
      reached_(scan, neighbours_.image()) {}

// Adds the points linked to these within the plane. It is fitted anew each time they are twice as many, as a
// side of 20 m is longer than a direction known from its first metre reaches.
template <class Ends>
SideSearch::Points SideSearch::linked_in_plane(Points found, const Vector3f& velocity, Ends&& ends,
                                               SlidingSide& side) {
  reached_.mark(found);
  fit(found, velocity, side);
  std::size_t fitted = found.size();
  bool ended = std::any_of(found.begin(), found.end(), ends);
  for (std::size_t next = 0; next < found.size() && !ended; ++next) {
    if (found.size() > 2 * fitted) {
      fit(found, velocity, side);
      fitted = found.size();
    }
    for_each_unreached(found[next], [&](std::int32_t j) {
      if (own_vehicle(j) || side.distance_m(at(j)) > kThickness_m) return;
      reached_.mark(j);
      found.push_back(j);
      ended = ended || ends(j);
    });
  }
  reached_.unmark(found);
  if (ended) found.clear();
  return found;
}

std::optional<SlidingSide> SideSearch::side_of(std::span<const std::int32_t> object,
                                               const Vector3f& velocity) {
  const Vector3f towards = velocity.normalized();
  float front_m = -kFar_m;
  for (const std::int32_t i : object) front_m = std::max(front_m, towards.dot(at(i)));
  const auto goes_on_ahead = [&](std::int32_t i) {
    return !moves(i) && towards.dot(at(i)) > front_m + kAhead_m;
  };
  Points beside = static_points_beside(object);
  for (int k = 0; k < kPlanes && beside.size() >= kLeastPoints; ++k) {
    SlidingSide side;
    if (!find_plane(beside, velocity, side)) return std::nullopt;
    const auto in_plane = [&](std::int32_t i) { return side.distance_m(at(i)) < kThickness_m / 2; };
    Points found;
    std::copy_if(beside.begin(), beside.end(), std::back_inserter(found), in_plane);
    std::copy_if(object.begin(), object.end(), std::back_inserter(found), in_plane);
    const Points linked = linked_in_plane(std::move(found), velocity, goes_on_ahead, side);
    if (runs_along(side, velocity) && measure(linked, side)) {
      place_points(side);
      const auto stands = [&](const SlidingSide::Point& p) { return !moves(p.number); };
      const auto standing = std::count_if(side.points.begin(), side.points.end(), stands);
      if (standing >= static_cast<std::ptrdiff_t>(kLeastPoints)) return side;
    }
    std::erase_if(beside, [&](std::int32_t i) { return side.distance_m(at(i)) < kThickness_m; });
  }
  return std::nullopt;
}

// Those linked to the object, and to these, up to kNear.
SideSearch::Points SideSearch::static_points_beside(std::span<const std::int32_t> object) {
  Points beside;
  const auto visit = [&](std::int32_t j) {
    if (moves(j) || own_vehicle(j)) return;
    reached_.mark(j);
    beside.push_back(j);
  };
  reached_.mark(object);  // it moves: its points need not be looked at
  for (const std::int32_t i : object) for_each_unreached(i, visit);
  for (std::size_t next = 0; next < beside.size() && beside.size() < kNear; ++next)
    for_each_unreached(beside[next], visit);
  reached_.unmark(object);
  reached_.unmark(beside);
  return beside;
}

// The plane along the velocity, of those through three of the points, in which most of them lie.
bool SideSearch::find_plane(const Points& among, const Vector3f& velocity, SlidingSide& side) const {
  std::size_t most = 0;
  std::uint32_t random = 1;  // the same points give the same plane
  const auto pick = [&]() -> const Vector3f& {
    random = random * 1664525U + 1013904223U;
    return at(among[(random >> 8U) % among.size()]);
  };
  const std::size_t stride = among.size() / kCounted + 1;
  SlidingSide plane;
  for (int k = 0; k < kTriples; ++k) {
    const Vector3f &a = pick(), &b = pick(), &c = pick();
    const Vector3f normal = (b - a).cross(c - a);
    if (normal.norm() < 0.01F) continue;  // nearly on a line
    plane.normal = normal.normalized();
    plane.offset_m = plane.normal.dot(a);
    if (!runs_along(plane, velocity)) continue;
    std::size_t count = 0;
    for (std::size_t n = 0; n < among.size(); n += stride)
      count += plane.distance_m(at(among[n])) < kThickness_m / 2 ? 1 : 0;
    if (count <= most) continue;
    most = count;
    side = plane;
  }
  return most * stride >= kLeastOfObject;
}

void SideSearch::fit(const Points& to, const Vector3f& velocity, SlidingSide& side) const {
  Vector3f mean = Vector3f::Zero();
  for (const std::int32_t i : to) mean += at(i);
  mean /= static_cast<float>(to.size());
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const std::int32_t i : to) {
    const Vector3f d = at(i) - mean;
    scatter += d * d.transpose();
  }
  side.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(scatter).eigenvectors().col(0);
  side.offset_m = side.normal.dot(mean);
  side.along = (velocity - velocity.dot(side.normal) * side.normal).normalized();
}

// How far moving points reach in the plane; false where they hardly do, or static ones go on ahead of them.
bool SideSearch::measure(const Points& linked, SlidingSide& side) const {
  const Vector3f across = side.across();
  side.front_m = side.highest_m = -kFar_m;
  side.lowest_m = kFar_m;
  float ahead_m = -kFar_m;
  std::size_t moving = 0;
  for (const std::int32_t i : linked) {
    const float along_m = side.along.dot(at(i)), height_m = across.dot(at(i));
    if (!moves(i)) {
      ahead_m = std::max(ahead_m, along_m);
      continue;
    }
    ++moving;
    side.front_m = std::max(side.front_m, along_m);
    side.lowest_m = std::min(side.lowest_m, height_m);
    side.highest_m = std::max(side.highest_m, height_m);
  }
  return moving >= kLeastOfObject && ahead_m < side.front_m + kAhead_m;
}

// All points of the plane as high as the object, linked or not: posts and gaps part a side.
void SideSearch::place_points(SlidingSide& side) const {
  const Vector3f across = side.across();
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(points_.size()); ++i) {
    if (side.distance_m(at(i)) > kThickness_m || own_vehicle(i)) continue;
    const float along_m = side.along.dot(at(i)), height_m = across.dot(at(i));
    if (height_m < side.lowest_m || height_m > side.highest_m || along_m > side.front_m + kAhead_m) continue;
    side.points.push_back({along_m, i});
  }
  std::stable_sort(side.points.begin(), side.points.end(),
                   [](const auto& a, const auto& b) { return a.along_m > b.along_m; });
  const auto gap =
      std::adjacent_find(side.points.begin(), side.points.end(),
                         [](const auto& a, const auto& b) { return a.along_m - b.along_m > kWidestGap_m; });
  if (gap != side.points.end()) side.points.erase(gap + 1, side.points.end());
}

}  // namespace mapless
