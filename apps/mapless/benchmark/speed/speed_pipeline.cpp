#include "benchmark/speed/speed_pipeline.hpp"

#include <algorithm>
#include <ctime>

namespace mapless::app {
namespace {

double process_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

SpeedPipeline::SpeedPipeline(int threads, bool side_by_side, const DetectorParameters& detector,
                             const OdometryParameters& odometry)
    : threads_(threads),
      side_by_side_(side_by_side),
      online_({detector, odometry, side_by_side, side_by_side ? threads - 1 : 0}),
      arena_(side_by_side ? 1 : threads) {}

void SpeedPipeline::add(const std::shared_ptr<const LidarScan>& scan, bool count) {
  const double process_start_s = process_seconds();
  BusyTime time = busy_time_of([&] { arena_.execute([&] { (void)online_.push(scan); }); });
  const double others_s = process_seconds() - process_start_s - time.processor_s;
  time.processor_s = std::max(time.processor_s, others_s);
  if (count) times_.push_back(time);
}

}  // namespace mapless::app
