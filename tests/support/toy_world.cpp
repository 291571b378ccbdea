#include "support/toy_world.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace mapless::test {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The part of a ray that lies inside a convex shape.
struct Span {
  double enter = -kInfinity;
  double leave = kInfinity;

  void intersect(double a, double b) {
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  void clear() { leave = -kInfinity; }
};

void clip_to_slab(Span& span, double origin, double direction, double half_size) {
  if (direction == 0) {
    if (std::abs(origin) > half_size) span.clear();
    return;
  }
  span.intersect((-half_size - origin) / direction, (half_size - origin) / direction);
}

/// Where |o + s d| = radius, for vectors of two or three dimensions.
template <class Vector>
void clip_to_radius(Span& span, const Vector& o, const Vector& d, double radius) {
  const double a = d.squaredNorm();
  const double b = o.dot(d);
  const double c = o.squaredNorm() - radius * radius;
  if (a == 0) {
    if (c > 0) span.clear();
    return;
  }
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return span.clear();
  const double root = std::sqrt(discriminant);
  span.intersect((-b - root) / a, (-b + root) / a);
}

/// Of a sphere around the body, with a margin for rounding.
double radius_around(const ToyBody& body) {
  constexpr double kMargin = 1.001;
  switch (body.shape) {
    case ToyShape::plane:
      break;
    case ToyShape::box:
      return kMargin * body.size_m.norm();
    case ToyShape::sphere:
      return kMargin * body.size_m.x();
    case ToyShape::cylinder:
      return kMargin * std::hypot(body.size_m.x(), body.size_m.z());
  }
  return kInfinity;
}

/// Whether the ray passes the sphere around a body, or has hit another one before it: most rays pass most
/// bodies, and this costs far less than to intersect them. In plain numbers, because the sanitizers make
/// vectors slow.
bool passes(const PlacedBody& place, const Vector3d& origin_0, const Vector3d& direction_0,
            double nearest_m) {
  const double x = place.centre_0.x() - origin_0.x();
  const double y = place.centre_0.y() - origin_0.y();
  const double z = place.centre_0.z() - origin_0.z();
  const double along = x * direction_0.x() + y * direction_0.y() + z * direction_0.z();
  const double r = place.radius_m;
  return along < -r || along - r > nearest_m || x * x + y * y + z * z - along * along > r * r;
}

}  // namespace

SE3 ToyBody::pose_at(Time t) const {
  const double s = t.seconds();
  const Vector3d position = T_0b.translation() + s * velocity_0;
  if (yaw_rate == 0) return {T_0b.rotation(), position};
  return {rotation_z(yaw_rate * s) * T_0b.rotation(), position};
}

double ToyBody::speed_at(const Vector3d& p_0, Time t) const {
  const Vector3d arm = p_0 - (T_0b.translation() + t.seconds() * velocity_0);
  return (velocity_0 + Vector3d(0, 0, yaw_rate).cross(arm)).norm();
}

ToyBody toy_ground(double height_m) {
  ToyBody body;
  body.shape = ToyShape::plane;
  body.T_0b = SE3(Eigen::Matrix3d::Identity(), Vector3d(0, 0, height_m));
  return body;
}

ToyBody toy_box(const Vector3d& centre, const Vector3d& half_size, double yaw_rad) {
  ToyBody body;
  body.T_0b = SE3(rotation_z(yaw_rad), centre);
  body.size_m = half_size;
  return body;
}

ToyBody toy_sphere(const Vector3d& centre, double radius_m) {
  ToyBody body = toy_box(centre, Vector3d::Constant(radius_m));
  body.shape = ToyShape::sphere;
  return body;
}

ToyBody toy_cylinder(const Vector3d& centre, double radius_m, double half_height_m) {
  ToyBody body = toy_box(centre, Vector3d(radius_m, radius_m, half_height_m));
  body.shape = ToyShape::cylinder;
  return body;
}

std::optional<double> intersect(const ToyBody& body, const Vector3d& o, const Vector3d& d) {
  Span span;
  switch (body.shape) {
    case ToyShape::plane:
      span.enter = d.z() == 0 ? -kInfinity : -o.z() / d.z();
      break;
    case ToyShape::box:
      for (int axis = 0; axis < 3; ++axis) clip_to_slab(span, o[axis], d[axis], body.size_m[axis]);
      break;
    case ToyShape::sphere:
      clip_to_radius(span, o, d, body.size_m.x());
      break;
    case ToyShape::cylinder:
      clip_to_radius(span, Eigen::Vector2d(o.head<2>()), Eigen::Vector2d(d.head<2>()), body.size_m.x());
      clip_to_slab(span, o.z(), d.z(), body.size_m.z());
      break;
  }
  if (span.enter > 0 && span.enter <= span.leave) return span.enter;
  return std::nullopt;
}

PlacedBody placed(const ToyBody& body, Time t) {
  const SE3 T_0b = body.pose_at(t);
  return {T_0b.inverse(), T_0b.translation(), radius_around(body)};
}

std::optional<ToyHit> first_hit(const ToyWorld& world, const std::vector<PlacedBody>& places,
                                const Vector3d& origin_0, const Vector3d& direction_0) {
  std::optional<ToyHit> first;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const PlacedBody& place = places[i];
    if (passes(place, origin_0, direction_0, first ? first->range_m : kInfinity)) continue;
    const auto range =
        intersect(world[i], moved(place.T_b0, origin_0), turned(place.T_b0.rotation(), direction_0));
    if (range && (!first || *range < first->range_m)) first = ToyHit{*range, i};
  }
  return first;
}

}  // namespace mapless::test
