#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/live/point_cloud2.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {

/// One cloud with its labels.
struct LiveOutput {
  PointCloud2 cloud;      ///< as it came
  LabelledScan labelled;  ///< one record per point of the cloud
  SE3 T_w0;               ///< world frame w of the outputs from the world 0 of `labelled`
  std::string world_frame;
  SE3 T_vb;                ///< sensor from the body b whose motion the own odometry states
  std::string body_frame;  ///< the name of b: LiveOptions::base_frame, else the frame of the clouds
  bool body_known = true;  ///< false where base_frame is not placed on the sensor yet
  /// From the arrival of the newest cloud that the labels needed, this one or the next, to the labels.
  double latency_s = 0;
  /// The poses of clouds with the same number are in one world; the own odometry that begins anew is in
  /// another.
  std::uint32_t world_number = 0;
};

/// Values of the field `moving`.
enum class PointMotion : std::uint8_t {
  still = 0,
  moving = 1,
  unknown = 255,  ///< a record without a return, or the motion of the sensor is lost
};

/// One per point of the cloud, in its order.
[[nodiscard]] std::vector<PointMotion> point_motions(const LiveOutput& output);

/// The cloud with every field it came with, and then `object_id` (uint32: TrackedObject::id, 0 where still),
/// `moving` (uint8, PointMotion) and `probability` (float32: that the point moves; NaN: unknown). Points,
/// order, stamp and frame are those of the cloud; bytes between rows are left out.
[[nodiscard]] PointCloud2 labelled_cloud(const LiveOutput& output);

/// The points of `motion` alone, with the fields of the cloud; height 1.
[[nodiscard]] PointCloud2 selected_cloud(const LiveOutput& output, PointMotion motion);

/// A moving object in the world frame w, at `time`.
struct LiveObject {
  std::uint32_t id = 0;
  Time time;
  Eigen::Vector3d centre_w = Eigen::Vector3d::Zero();               ///< [m]
  Eigen::Matrix3d rotation_wb = Eigen::Matrix3d::Identity();        ///< of the box
  Eigen::Vector3d extent_b = Eigen::Vector3d::Zero();               ///< lengths of the sides [m]
  Eigen::Vector3d velocity_w = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Matrix3d velocity_covariance_w = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
};

[[nodiscard]] std::vector<LiveObject> live_objects(const LiveOutput& output);

/// Pose and velocity of the body b in the form of nav_msgs/Odometry: covariances of (translation,
/// rotation), that of the pose along and about the axes of w, that of the velocity in b. The covariance of
/// the pose is relative to the map of the last 100 m: it does not hold the drift.
struct LiveOdometry {
  Time time;  ///< the end of the scan
  SE3 T_wb;
  Matrix6d pose_covariance_w = Matrix6d::Zero();
  Vector6d velocity_b = Vector6d::Zero();  ///< [m/s, rad/s]
  Matrix6d velocity_covariance_b = Matrix6d::Zero();
};

/// None where poses were given, the motion is lost, or the body is not known.
[[nodiscard]] std::optional<LiveOdometry> live_odometry(const LiveOutput& output);

/// A pose of the body b in the world frame w.
struct LivePose {
  Time time;
  SE3 T_wb;
};

/// Poses of the own odometry at five instants of the scan, the last one at its end, for tf: another lidar on
/// the same body turns at instants of its own. Empty where live_odometry is none.
[[nodiscard]] std::vector<LivePose> live_poses(const LiveOutput& output);

/// As geometry_msgs/TransformStamped.
struct LiveTransform {
  Time time;
  std::string parent, child;
  SE3 T_parent_child;
};

/// live_poses for tf. `inverted`: the world is the child of the body.
[[nodiscard]] std::vector<LiveTransform> live_transforms(const LiveOutput& output, bool inverted);

/// As diagnostic_msgs/DiagnosticStatus.
enum class LiveLevel : std::uint8_t { ok = 0, warning = 1, error = 2 };

/// Something that happened, for the log.
struct LiveEvent {
  LiveLevel level;
  std::string text;
};

/// The state of a LiveDetector, as diagnostic_msgs/DiagnosticStatus holds it.
struct LiveDiagnostics {
  LiveLevel level = LiveLevel::ok;
  std::string message;
  bool has_clouds = false;                                  ///< one has come
  std::string sensor;                                       ///< name of the model; empty: not known yet
  std::vector<std::pair<std::string, std::string>> values;  ///< clouds, rates, latencies, motion
};

}  // namespace mapless
