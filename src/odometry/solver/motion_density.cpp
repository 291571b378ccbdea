#include "odometry/solver/motion_density.hpp"

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kRemembered = 20;  // intervals
constexpr double kExpectedCounts = 2;    // intervals
// Mean velocities of two intervals dt differ by 2/3 dt Qc where the acceleration is white. Rotations are
// smooth: with an acceleration a that lasts, the difference is a dt, and the error of the prior,
// (a dt^2 / 2, a dt), is as large as its two freedoms make it, e^T Q^-1 e = 2, for Qc = a^2 dt / 2, a third
// of what the difference seems to say. Brakes and engines act within a scan.
constexpr double kSmoothRotation = 1.0 / 3;

Vector6d mean_velocity(const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  return (k2.T_v0 * k1.T_v0.inverse()).log() / (k2.time - k1.time).seconds();
}

}  // namespace

AccelerationDensity density_of(std::span<const TrajectoryKnot> knots, const AccelerationDensity& expected) {
  if (knots.size() > kRemembered + 1) knots = knots.last(kRemembered + 1);
  double translation = kExpectedCounts * expected.translation;
  double rotation = kExpectedCounts * expected.rotation;
  double count = kExpectedCounts;
  for (std::size_t k = 2; k < knots.size(); ++k) {
    const Vector6d change = mean_velocity(knots[k - 1], knots[k]) - mean_velocity(knots[k - 2], knots[k - 1]);
    // Of three axes together.
    const double per_density = (knots[k].time - knots[k - 2].time).seconds();
    translation += change.head<3>().squaredNorm() / per_density;
    rotation += kSmoothRotation * change.tail<3>().squaredNorm() / per_density;
    count += 1;
  }
  return {translation / count, rotation / count, expected.translation, expected.rotation};
}

}  // namespace mapless
