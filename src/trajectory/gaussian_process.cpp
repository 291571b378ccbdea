#include <algorithm>

#include "trajectory/domain.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless {

// Anderson and Barfoot, IROS 2015; method.md section 3. In the coordinates gamma(t) = ln(T(t) T_1^-1) the
// posterior mean is the cubic through both ends with their velocities: its coefficients do not depend on Qc.
TrajectoryState interpolate(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Time t) {
  const double dt = (k2.time - k1.time).seconds();
  const double r = (t - k1.time).seconds() / dt;
  const double r2 = r * r;
  const double r3 = r2 * r;
  const Vector6d xi = (k2.T_v0 * k1.T_v0.inverse()).log();
  const Vector6d velocity_2 = left_jacobian_inverse(xi) * k2.varpi;
  const Vector6d gamma =
      dt * (r - 2 * r2 + r3) * k1.varpi + (3 * r2 - 2 * r3) * xi + dt * (r3 - r2) * velocity_2;
  const Vector6d gamma_dot =
      (1 - 4 * r + 3 * r2) * k1.varpi + 6 * (r - r2) / dt * xi + (3 * r2 - 2 * r) * velocity_2;
  return {SE3::exp(gamma) * k1.T_v0, left_jacobian(gamma) * gamma_dot};
}

GaussianProcessTrajectory::GaussianProcessTrajectory(std::vector<TrajectoryKnot> knots, std::string source)
    : knots_(std::move(knots)), source_(std::move(source)) {
  IncreasingTimes times(source_, "knot");
  for (const TrajectoryKnot& knot : knots_) times.add(knot.time);
  times.finish();
}

TrajectoryState GaussianProcessTrajectory::at(Time t) const {
  require_covered(t, begin(), end(), source_);
  const auto second =
      std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t,
                       [](Time time, const TrajectoryKnot& knot) { return time < knot.time; });
  return interpolate(*(second - 1), *second, t);
}

}  // namespace mapless
