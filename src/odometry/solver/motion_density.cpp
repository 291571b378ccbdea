#include "odometry/solver/motion_density.hpp"

namespace mapless::inline v1 {
namespace {

// Length of the sliding window, in intervals between knots: 2 s at 10 Hz. Chosen: the relative error of a
// variance from 19 differences on 3 axes is a fifth, and a braking vehicle changes its density within
// seconds.
constexpr std::size_t kWindowIntervals = kDensityKnots - 1;
// Weight of the expected density, in intervals. Chosen: the density is not zero after two equal velocities.
constexpr double kExpectedWeight = 2;
// Derived. If the acceleration is white, the mean velocities of two intervals dt differ by d with
// E[d^2] = 2/3 dt Qc per axis, hence Qc = 3/2 d^2 / dt. Rotation is smooth: under a constant acceleration a,
// d = a dt, the error of the prior is (a dt^2 / 2, a dt), and e^T Q^-1 e equals its two degrees of freedom
// for Qc = d^2 / (2 dt), a third of 3/2 d^2 / dt. Brakes and engines act within a scan, so that translation
// is taken as white.
constexpr double kSmoothRotation = 1.0 / 3;

Vector6d mean_velocity(const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  return (k2.T_v0 * k1.T_v0.inverse()).log() / (k2.time - k1.time).seconds();
}

}  // namespace

AccelerationDensity estimate_density(std::span<const TrajectoryKnot> knots,
                                     const AccelerationDensity& expected) {
  if (knots.size() > kWindowIntervals + 1) knots = knots.last(kWindowIntervals + 1);
  double translation = kExpectedWeight * expected.translation;
  double rotation = kExpectedWeight * expected.rotation;
  double count = kExpectedWeight;
  for (std::size_t k = 2; k < knots.size(); ++k) {
    const Vector6d change = mean_velocity(knots[k - 1], knots[k]) - mean_velocity(knots[k - 2], knots[k - 1]);
    // Sum over three axes: E|d|^2 = 3 * 2/3 dt Qc = 2 dt Qc, and 2 dt is the time between the outer knots.
    const double per_density = (knots[k].time - knots[k - 2].time).seconds();
    translation += change.head<3>().squaredNorm() / per_density;
    rotation += kSmoothRotation * change.tail<3>().squaredNorm() / per_density;
    count += 1;
  }
  return {translation / count, rotation / count, expected.translation, expected.rotation};
}

}  // namespace mapless
