#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <mapless/core/parameters.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {

/// Where the motion of the lidar comes from.
enum class LiveMotion : std::uint8_t {
  own,       ///< lidar odometry
  tf,        ///< transforms of the frames (tf, tf_static)
  odometry,  ///< poses of another odometry (nav_msgs/Odometry), and tf_static for the place of the lidar
};
[[nodiscard]] inline std::span<const std::string_view> choice_names(LiveMotion) {
  static constexpr std::array<std::string_view, 3> kNames = {"own", "tf", "odometry"};
  return kNames;
}

/// Parameters of a LiveDetector beside those of detection and odometry.
struct LiveParameters {
  LiveMotion motion = LiveMotion::own;
  bool use_imu = false;
  bool use_wheel_odometry = false;
  bool publish_tf = false;
  bool invert_odom_tf = false;
  int queue_clouds = 5;
  int start_queue_clouds = 40;
  double max_gap_s = 1.0;
  double pose_wait_s = 0.3;
  double clock_offset_s = 0;
  double static_map_voxel_m = 0.2;
  int static_map_max_voxels = 5'000'000;

  static constexpr auto declarations() {
    using P = LiveParameters;
    return std::tuple{
        declare(&P::motion, "motion",
                "where the motion of the lidar comes from: own (lidar odometry), tf (tf and tf_static), or "
                "odometry (topic odometry_in and tf_static)",
                "docs/ros2.md"),
        declare(&P::use_imu, "use_imu",
                "own odometry uses the angular velocities of topic imu, whose frame tf_static places on the "
                "lidar",
                "docs/ros2.md"),
        declare(&P::use_wheel_odometry, "use_wheel_odometry",
                "own odometry uses the speed by the twist of topic wheel_odometry, whose child frame "
                "tf_static places on the lidar",
                "docs/ros2.md"),
        declare(&P::publish_tf, "publish_tf", "write the own odometry to tf, too", "docs/ros2.md"),
        declare(&P::invert_odom_tf, "invert_odom_tf",
                "in tf the base frame is the parent of the world frame: for a base frame that has another "
                "parent already",
                "docs/ros2.md"),
        declare(&P::queue_clouds, "queue_clouds", "clouds", 1, 1000,
                "clouds that wait for detection; where more arrive, the oldest is dropped",
                "depth of the sensor-data profile of ROS 2"),
        declare(
            &P::start_queue_clouds, "start_queue_clouds", "clouds", 1, 1000,
            "the same until the first labels, for at most 5 s: own odometry needs the first scans without "
            "a gap, and takes longer for them; then every other cloud is dropped until queue_clouds wait",
            "docs/ros2.md"),
        declare(&P::max_gap_s, "max_gap_s", "s", 0.1, 60,
                "detection begins anew after a longer time without clouds, and where stamps jump farther",
                "docs/ros2.md"),
        declare(&P::pose_wait_s, "pose_wait_s", "s", 0, 10,
                "with poses from tf or a topic: a cloud waits at most this long for poses that cover it",
                "docs/ros2.md"),
        declare(
            &P::clock_offset_s, "clock_offset_s", "s", -2e9, 2e9,
            "added to the stamps of the clouds where the clock of the lidar is not that of the poses, the "
            "imu and the wheels; labelled clouds keep their stamps",
            "docs/rigs.md"),
        declare(&P::static_map_voxel_m, "static_map_voxel_m", "m", 0.01, 10,
                "with static_map_file: edge of a voxel, which becomes one point of the map",
                "chosen: a map of 0.1 m has three times as many"),
        declare(&P::static_map_max_voxels, "static_map_max_voxels", "voxels", 1000, 100'000'000,
                "with static_map_file: points of further voxels are left out; memory: 72 bytes a voxel",
                "chosen: 360 MB, 580 MB while the file is written"),
    };
  }
};

/// Settings of a LiveDetector.
struct LiveOptions {
  OnlineDetectorOptions detector;
  LiveParameters live;
  std::optional<LidarModel> sensor;  ///< none: recovered from the first eight clouds
  /// Own odometry is of this frame, which static transforms place on the sensor; empty: of the clouds' frame.
  std::string base_frame;
  std::string world_frame = "odom";  ///< of objects and odometry; with given poses, the top of the transforms
  std::string topic = "points";      ///< of the clouds, for messages
  std::string sensor_name;           ///< for shells: the name or calibration file that `sensor` is read from
  std::string static_map_file;       ///< that StaticMap writes: .pcd, .ply or .las; empty: no map is kept

  /// Whether LiveDetector::add_transform gives the poses.
  [[nodiscard]] bool poses_given() const { return live.motion != LiveMotion::own; }
  /// Whether static transforms are needed.
  [[nodiscard]] bool needs_frames() const {
    return poses_given() || !base_frame.empty() || live.use_imu || live.use_wheel_odometry;
  }
};

/// A setting that is a text.
struct LiveSetting {
  std::string_view name;
  std::string* value;
  std::string_view help;
};

/// The texts of `options` that a user sets: sensor, world_frame, base_frame, static_map_file.
[[nodiscard]] std::vector<LiveSetting> live_settings(LiveOptions& options);
/// The parameters of detection under their own keys, those of odometry under "odometry.", and those of
/// LiveParameters.
[[nodiscard]] std::vector<ParameterReference> live_parameters(LiveOptions& options);

/// A topic that another node publishes, and the type of its messages, such as "sensor_msgs/msg/PointCloud2".
struct PublishedTopic {
  std::string name, type;
};

/// Why no cloud comes on topic `points`, and what to do, for the diagnostics of a node that waits for one:
/// the topic carries other messages, nobody publishes on it, or clouds are lost on their way.
[[nodiscard]] std::string why_no_cloud(const std::string& points,
                                       const std::vector<PublishedTopic>& published);

/// The names of those that carry clouds, sorted, each once; without the outputs of mapless.
[[nodiscard]] std::vector<std::string> cloud_topics(const std::vector<PublishedTopic>& published);

}  // namespace mapless
