#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include "core/argument_checks.hpp"
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

MountedTrajectory::MountedTrajectory(std::shared_ptr<const Trajectory> of_v, const SE3& T_wv,
                                     Duration extrapolation)
    : of_v_(std::move(of_v)), T_wv_(T_wv), extrapolation_(extrapolation) {
  require_given("MountedTrajectory", "of_v", of_v_.get());
}

// d/dt T_w0 = T_wv varpi_v^ T_v0, which is (Ad(T_wv) varpi_v)^ T_w0.
TrajectoryState MountedTrajectory::at(Time t) const {
  const Time within = begin() <= t && t <= end() ? std::clamp(t, of_v_->begin(), of_v_->end()) : t;
  TrajectoryState v = of_v_->at(within);
  if (t != within) v.T_v0 = SE3::exp((t - within).seconds() * v.varpi) * v.T_v0;
  TrajectoryState w;
  w.T_v0 = T_wv_ * v.T_v0;
  const Eigen::Vector3d turning = T_wv_.rotation() * v.varpi.tail<3>();
  w.varpi << T_wv_.rotation() * v.varpi.head<3>() + T_wv_.translation().cross(turning), turning;
  return w;
}

}  // namespace mapless
