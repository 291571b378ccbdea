#pragma once

#include <memory>
#include <string>
#include <vector>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vision_msgs/msg/detection3_d_array.hpp>
#include <visualization_msgs/msg/marker_array.hpp>

#include <mapless/live/live_detector.hpp>

namespace mapless_ros {

mapless::Time time_of(const builtin_interfaces::msg::Time& stamp);

void add_transforms(mapless::LiveDetector& live, const tf2_msgs::msg::TFMessage& message, bool is_static);
/// The pose of another odometry, in the world frame.
void add_pose(mapless::LiveDetector& live, const nav_msgs::msg::Odometry& message,
              const std::string& world_frame);
void add_imu(mapless::LiveDetector& live, const sensor_msgs::msg::Imu& message);
void add_wheels(mapless::LiveDetector& live, const nav_msgs::msg::Odometry& message);

/// Without a copy of the points.
mapless::PointCloud2 cloud_of(const sensor_msgs::msg::PointCloud2::ConstSharedPtr& message);

sensor_msgs::msg::PointCloud2::UniquePtr cloud_message(const mapless::PointCloud2& cloud);
nav_msgs::msg::Odometry odometry_message(const mapless::LiveOdometry& odometry,
                                         const std::string& world_frame, const std::string& body_frame);
tf2_msgs::msg::TFMessage transforms_message(const std::vector<mapless::LiveTransform>& transforms);
diagnostic_msgs::msg::DiagnosticStatus status_message(const mapless::LiveDiagnostics& diagnostics,
                                                      const std::string& name);
vision_msgs::msg::Detection3DArray objects_message(const mapless::LiveOutput& output);
visualization_msgs::msg::MarkerArray markers_message(const mapless::LiveOutput& output);

}  // namespace mapless_ros
