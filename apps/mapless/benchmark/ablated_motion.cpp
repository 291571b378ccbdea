#include "benchmark/ablated_motion.hpp"

namespace mapless::app {
namespace {

Time middle_of(const LidarScan& scan) {
  return scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2);
}

// Each point p moved to T_b0(its instant) T_a0(its instant)^-1 p.
std::shared_ptr<const LidarScan> moved(const LidarScan& scan, const Trajectory& a, const Trajectory& b) {
  LidarScan out = scan;
  for (LidarReturn& r : out.returns) {
    const Time t = scan.time_of(r);
    const SE3 T_ba = b.at(t).T_v0 * a.at(t).T_v0.inverse();
    r.position_v = (T_ba * r.position_v.cast<double>()).cast<float>();
  }
  return std::make_shared<const LidarScan>(std::move(out));
}

}  // namespace

DetectorInput ablate_motion(std::shared_ptr<const LidarScan> scan,
                            std::shared_ptr<const Trajectory> trajectory, Compensation compensation) {
  if (compensation == Compensation::full) return {std::move(scan), std::move(trajectory)};
  const auto frozen = std::make_shared<const FrozenTrajectory>(*trajectory, middle_of(*scan));
  switch (compensation) {
    case Compensation::not_of_clouds:
      // Frame 0 by the trajectory from `moved`: T_v0^-1 T_v0 T_m0^-1 p = T_m0^-1 p.
      return {moved(*scan, *frozen, *trajectory), std::move(trajectory)};
    case Compensation::not_of_rays:
      // Frame 0 by the frozen pose: T_m0^-1 T_m0 T_v0^-1 p = T_v0^-1 p.
      return {moved(*scan, *trajectory, *frozen), frozen};
    default:
      return {std::move(scan), frozen};
  }
}

}  // namespace mapless::app
