#include "benchmark/speed/speed_pipeline.hpp"

#include <algorithm>

namespace mapless::app {
namespace {

constexpr std::ptrdiff_t kKnotsOfAScan = 4;  // its own, the one before, and those of a gap

// The motion during the newest scan, as odometry knows it now.
GaussianProcessTrajectory newest_motion(const LidarOdometry& odometry) {
  const auto& knots = odometry.knots();
  const auto count = std::min(kKnotsOfAScan, static_cast<std::ptrdiff_t>(knots.size()));
  return {{knots.end() - count, knots.end()}, "lidar odometry"};
}

void leave_out(LidarOdometry& odometry, const std::vector<Detection>& found) {
  for (const Detection& detection : found) odometry.remove_dynamic_points(*detection.scan, detection.object);
}

}  // namespace

SpeedPipeline::SpeedPipeline(int threads, bool side_by_side, const DetectorParameters& detector,
                             const OdometryParameters& odometry)
    : threads_(threads),
      side_by_side_(side_by_side),
      detector_(detector),
      odometry_(odometry),
      arena_(std::max(1, side_by_side ? threads - 1 : threads)) {}

void SpeedPipeline::add(const std::shared_ptr<const LidarScan>& scan, bool count) {
  side_time_ = {};
  BusyTime time = busy_time_of([&] {
    if (side_by_side_) {
      beside_each_other(scan);
    } else {
      arena_.execute([&] { after_one_another(scan); });
    }
  });
  time.processor_s = std::max(time.processor_s, side_time_.processor_s);
  if (!count) return;
  times_.push_back(time);
  odometry_times_.push_back(odometry_time_);
}

void SpeedPipeline::register_scan(const std::shared_ptr<const LidarScan>& scan) {
  odometry_time_ = busy_time_of([&] { odometry_.process(scan); });
}

void SpeedPipeline::after_one_another(const std::shared_ptr<const LidarScan>& scan) {
  register_scan(scan);
  leave_out(odometry_, detector_.process(scan, odometry_.trajectory()));
}

// What is found moving leaves the map after the next scan has been registered.
void SpeedPipeline::beside_each_other(const std::shared_ptr<const LidarScan>& scan) {
  std::vector<Detection> found;
  const auto detect = [&] {
    side_time_ =
        busy_time_of([&] { arena_.execute([&] { found = detector_.process(before_, *motion_before_); }); });
  };
  if (before_) side_.start(detect);
  odometry_arena_.execute([&] { register_scan(scan); });
  if (before_) side_.wait();
  leave_out(odometry_, found);
  before_ = scan;
  motion_before_ = newest_motion(odometry_);
}

}  // namespace mapless::app
