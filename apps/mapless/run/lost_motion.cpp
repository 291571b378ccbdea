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

std::string motion_lost_line(std::size_t lost, std::size_t scans) {
  return fmt::format(
      "finished; {} of {} scans are without motion: give the poses of another source (--trajectory FILE)",
      lost, scans);
}

}  // namespace mapless::app
