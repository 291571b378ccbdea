#pragma once

#include <cstdint>
#include <cstring>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "support/toy_scene.hpp"
#include <mapless/live/live_detector.hpp>

namespace mapless::test {

inline constexpr int kScans = 24;
inline constexpr int kTurnMs = 100;  // a VLP-16
inline constexpr std::uint32_t kStep = 22;
// Two seconds after a fault at most, labels come again.
inline constexpr int kCloudsToRecover = 20;

inline const ToyScene& street() {
  static const ToyScene scene = with_columns(toy_street("VLP-16"), 400);
  return scene;
}

inline const std::vector<ToyScan>& scans() {
  static const std::vector<ToyScan> all = [] {
    std::vector<ToyScan> made;
    for (int k = 0; k < kScans; ++k) made.push_back(cast_scan(street(), k));
    return made;
  }();
  return all;
}

inline Time at_ms(std::int64_t ms) { return Time::from_nanoseconds(ms * 1'000'000); }

// As the Velodyne driver publishes a scan, without the rays that saw nothing; `time_name` names its times.
inline PointCloud2 cloud_of(const ToyScan& scan, Time stamp, const std::string& time_name = "time") {
  auto bytes = std::make_shared<std::vector<std::uint8_t>>();
  for (const LidarRecord& r : scan.records) {
    if (r.code != ReturnCode::hit) continue;
    std::uint8_t point[kStep] = {};
    const auto ring = static_cast<std::uint16_t>(r.laser);
    const float time_s = static_cast<float>(r.time_ns) * 1e-9F;
    const float intensity = 0.5F;
    std::memcpy(point, r.position_v.data(), 12);
    std::memcpy(point + 12, &intensity, 4);
    std::memcpy(point + 16, &ring, 2);
    std::memcpy(point + 18, &time_s, 4);
    bytes->insert(bytes->end(), point, point + kStep);
  }
  PointCloud2 cloud;
  cloud.view.stamp = stamp;
  cloud.view.frame_id = "lidar";
  cloud.view.fields = {{"x", 0, 7, 1},          {"y", 4, 7, 1},     {"z", 8, 7, 1},
                       {"intensity", 12, 7, 1}, {"ring", 16, 4, 1}, {time_name, 18, 7, 1}};
  cloud.view.point_step = kStep;
  cloud.view.width = static_cast<std::uint32_t>(bytes->size() / kStep);
  cloud.view.row_step = static_cast<std::uint32_t>(bytes->size());
  cloud.view.data = *bytes;
  cloud.owner = bytes;
  return cloud;
}

inline PointCloud2 cloud(int k) {
  return cloud_of(scans()[static_cast<std::size_t>(k)], at_ms(1000 + kTurnMs * k));
}

// A LiveDetector and the time of its clock, which stands still between calls.
class Robot {
 public:
  explicit Robot(LiveOptions options) : live_(options, [this] { return now_; }) {}

  void pass_ms(int ms) { now_ = now_ + Duration::from_nanoseconds(std::int64_t{ms} * 1'000'000); }
  void add(PointCloud2 cloud, std::uint64_t publisher = 1) { live_.add_cloud(std::move(cloud), publisher); }
  std::size_t process() {
    std::vector<LiveOutput> more = live_.process();
    const std::size_t count = more.size();
    std::move(more.begin(), more.end(), std::back_inserter(outputs_));
    return count;
  }
  // A turn later, the cloud arrives and is processed.
  std::size_t turn(PointCloud2 cloud, std::uint64_t publisher = 1) {
    pass_ms(kTurnMs);
    add(std::move(cloud), publisher);
    return process();
  }
  void drive(int first, int end) {
    for (int k = first; k < end; ++k) turn(cloud(k));
  }
  // Turns until labels of a cloud with a stamp from `from` on come.
  int turns_until_labels(int first_scan, Time from, Duration shift, std::uint64_t publisher = 1) {
    for (int i = 0; i < kCloudsToRecover; ++i) {
      const int k = (first_scan + i) % kScans;
      PointCloud2 next = cloud(k);
      next.view.stamp = from + shift + Duration::from_nanoseconds(std::int64_t{i} * kTurnMs * 1'000'000);
      turn(std::move(next), publisher);
      if (!outputs_.empty() && outputs_.back().cloud.view.stamp >= from + shift) return i + 1;
    }
    return kCloudsToRecover + 1;
  }

  [[nodiscard]] LiveDiagnostics diagnostics() const { return live_.diagnostics(); }
  [[nodiscard]] std::string value(const std::string& key) const {
    for (const auto& [name, text] : diagnostics().values) {
      if (name == key) return text;
    }
    return "no such value";
  }
  [[nodiscard]] const std::vector<LiveOutput>& outputs() const { return outputs_; }
  LiveDetector& live() { return live_; }

 private:
  Time now_ = at_ms(500'000);
  LiveDetector live_;
  std::vector<LiveOutput> outputs_;
};

inline LiveOptions with_own_odometry() {
  LiveOptions options;
  options.sensor = *street().model;
  return options;
}

inline LiveOptions with_poses() {
  LiveOptions options = with_own_odometry();
  options.live.motion = LiveMotion::tf;
  options.live.pose_wait_s = 0.25;
  return options;
}

// Poses as wheel odometry has them, 20 times a second, of base_link; the lidar is 2 m above it. `shift`: of
// the stamps from the times of the scene.
inline void add_poses(Robot& robot, int from_ms, int to_ms) {
  const SE3 T_bv(Eigen::Matrix3d::Identity(), {0, 0, 2});
  robot.live().add_transform("base_link", "lidar", Time(), T_bv, true);
  for (int ms = from_ms; ms <= to_ms; ms += 50) {
    const SE3 T_0v = street().trajectory->at(at_ms(ms - 1000)).T_v0.inverse();
    robot.live().add_transform("odom", "base_link", at_ms(ms), T_0v * T_bv.inverse(), false);
  }
}

// A robot with poses for the first scans that has labelled most of them.
inline std::unique_ptr<Robot> driving(int clouds) {
  auto robot = std::make_unique<Robot>(with_poses());
  add_poses(*robot, 1000, 1000 + kTurnMs * kScans);
  robot->drive(0, clouds);
  return robot;
}

}  // namespace mapless::test
