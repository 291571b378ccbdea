#include "run/lost_motion.hpp"

#include <fmt/format.h>

namespace mapless::app {

MotionRow motion_row(std::size_t scan, const TimedPose& pose, double duration_s,
                     const OdometryUpdate& update) {
  return {scan,
          pose,
          name_of(update.state),
          update.inlier_ratio,
          update.mean_robust_weight,
          update.degeneracy.constraint_ratio[0],
          update.motion_covariance_v(duration_s)};
}

std::string motion_doubt(const OdometryReport& report) {
  const std::size_t lost = report.count(MotionState::lost);
  if (lost > 0) {
    return fmt::format(
        "{} of {} scans are without motion: give the poses of another source (--trajectory FILE)", lost,
        report.scans());
  }
  if (report.scans() == 0 || report.count(MotionState::good) > 0) return "";
  return fmt::format(
      "the motion is not certain in any of the {} scans (own odometry needs the first five to ten to begin, "
      "and the "
      "sensor's own vehicle is found once it has moved): give more scans, or the poses of another source "
      "(--trajectory FILE)",
      report.scans());
}

}  // namespace mapless::app
