#include "detection/tracking/completion/body_completion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>

#include "detection/dynamic_returns.hpp"

namespace mapless::inline v1 {
namespace {

// Measured on 15 recordings of a second simulator: of the points beside dynamic objects with these votes or
// more, nine in ten move; of those with fewer, one in four.
constexpr int kBodyVotes = kSeenThroughVotes;

// A velocity is sure to differ from zero by this many standard deviations. Chosen: 99.7 % of a Gaussian.
constexpr double kSureDeviations = 3;

struct MovingBody {
  std::uint16_t number = 0;
  std::vector<Eigen::Vector3f> points;
  Eigen::AlignedBox3f box;  // around all places within reach
  float reach_m = 0;
};

// Half of its size: the distance of its farthest point from the mean of all.
float radius_m(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& p : points) mean += p;
  mean /= static_cast<float>(points.size());
  float radius2_m2 = 0;
  for (const Eigen::Vector3f& p : points) radius2_m2 = std::max(radius2_m2, (p - mean).squaredNorm());
  return std::sqrt(radius2_m2);
}

std::vector<MovingBody> moving_bodies(const LocalPoints& points, const std::vector<TrackedObject>& tracked,
                                      const std::vector<TrackMotion>& motions,
                                      const std::vector<std::uint16_t>& object) {
  std::vector<MovingBody> bodies;
  std::vector<std::int32_t> body_of(motions.size(), -1);
  for (const TrackedObject& one : tracked) {
    if (!motions[one.number - 1U].moves || !surely_moves(one)) continue;
    body_of[one.number - 1U] = static_cast<std::int32_t>(bodies.size());
    bodies.emplace_back().number = one.number;
  }
  for_each_dynamic(object, [&](std::size_t i) {
    if (const std::int32_t b = body_of[object[i] - 1U]; b >= 0)
      bodies[static_cast<std::size_t>(b)].points.push_back(points.points[i]);
  });
  for (MovingBody& body : bodies) {
    body.reach_m = std::min(radius_m(body.points), kMaxBodyReach_m);
    for (const Eigen::Vector3f& p : body.points) body.box.extend(p);
    const Eigen::Vector3f reach = Eigen::Vector3f::Constant(body.reach_m);
    body.box = {body.box.min() - reach, body.box.max() + reach};
  }
  return bodies;
}

// The number of the body with the nearest point within its reach; 0: none.
std::uint16_t body_beside(const Eigen::Vector3f& point, const std::vector<MovingBody>& bodies) {
  std::uint16_t number = 0;
  float nearest2_m2 = std::numeric_limits<float>::infinity();
  for (const MovingBody& body : bodies) {
    if (!body.box.contains(point)) continue;
    for (const Eigen::Vector3f& p : body.points) {
      const float distance2_m2 = (p - point).squaredNorm();
      if (distance2_m2 >= nearest2_m2 || distance2_m2 > body.reach_m * body.reach_m) continue;
      nearest2_m2 = distance2_m2;
      number = body.number;
    }
  }
  return number;
}

}  // namespace

bool surely_moves(const TrackedObject& object) {
  return object.velocity_0.norm() >= kSureDeviations * object.velocity_std_0().maxCoeff();
}

std::vector<std::uint32_t> complete_bodies(const LocalPoints& points, const std::vector<PointEvidence>& votes,
                                           const std::vector<TrackedObject>& tracked,
                                           const std::vector<TrackMotion>& motions,
                                           std::vector<std::uint16_t>& object) {
  std::vector<std::uint32_t> taken;
  const std::vector<MovingBody> bodies = moving_bodies(points, tracked, motions, object);
  if (bodies.empty()) return taken;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (votes[i].total() < kBodyVotes) continue;
    if (object[i] != 0 && (motions[object[i] - 1U].moves || motions[object[i] - 1U].slow)) continue;
    const std::uint16_t number = body_beside(points.points[i], bodies);
    if (number == 0) continue;
    object[i] = number;
    taken.push_back(static_cast<std::uint32_t>(i));
  }
  return taken;
}

}  // namespace mapless
