#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

/// Errors of the final motion from scan to scan of a simulated drive, from scan 10 on.
class SettledError {
 public:
  SettledError(const std::string& sensor, const std::string& scene, std::uint64_t seed, int scans) {
    constexpr int kSettled = 10;
    const Scene made = make_scene(scene, {seed, 0.1 * (scans + 1), true});
    const auto truth = std::make_shared<const SampledTrajectory>(made.poses, Duration(), "scene");
    SimulatedWorld world(made.world);
    SimulatedSensor simulated(std::make_shared<const LidarModel>(named_model(sensor)), truth, world,
                              {0.02, true, seed});
    LidarOdometry odometry;
    std::vector<std::pair<Time, Time>> settled;
    for (int k = 0; k < scans; ++k) {
      const auto scan = simulated.lidar_scan(k);
      (void)odometry.process(scan);
      if (k >= kSettled) settled.emplace_back(scan->start, scan->end());
    }
    double sum = 0;
    for (const auto& [start, end] : settled) {
      const auto moved = [&](const Trajectory& t) { return t.at(start).T_v0 * t.at(end).T_v0.inverse(); };
      const Vector6d error = (moved(odometry.trajectory()) * moved(*truth).inverse()).log();
      const double error_m = error.head<3>().norm();
      sum += error_m * error_m;
      largest_m = std::max(largest_m, error_m);
    }
    rms_m = std::sqrt(sum / (scans - kSettled));
  }

  double rms_m = 0, largest_m = 0;
};

const SettledError& dense_flyer() {
  static const SettledError error("OS1-128", "flyer", 801, 40);
  return error;
}

// Above a hill one point in 2,000 constrains the horizontal motion. With the usual number of keypoints the
// motion of a scan errs by 3.9 mm, with three times as many by 2.5 mm.
TEST(WeakConstraint, AddsKeypointsIfADirectionIsWeaklyConstrained) { EXPECT_LT(dense_flyer().rms_m, 0.0032); }

// A constraint ratio of 3 in 10,000 is still used: with the prior alone, scan after scan, the speed along
// that direction diverges to 300 m/s, and the density of the prior with it.
TEST(WeakConstraint, AFewPointsConstrainADirection) { EXPECT_LT(dense_flyer().largest_m, 0.05); }

}  // namespace MAPLESS_FILE
}  // namespace mapless
