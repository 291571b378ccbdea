#include "messages.hpp"

#include <algorithm>
#include <functional>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace mapless_ros {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

builtin_interfaces::msg::Time stamp_of(mapless::Time time) {
  builtin_interfaces::msg::Time stamp;
  const std::int64_t ns = std::max<std::int64_t>(time.nanoseconds(), 0);
  stamp.sec = static_cast<std::int32_t>(ns / kNanosecondsPerSecond);
  stamp.nanosec = static_cast<std::uint32_t>(ns % kNanosecondsPerSecond);
  return stamp;
}

template <class Vector>
void set(Vector& to, const Eigen::Vector3d& from) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

void set(geometry_msgs::msg::Quaternion& to, const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  to.x = q.x();
  to.y = q.y();
  to.z = q.z();
  to.w = q.w();
}

void set(geometry_msgs::msg::Pose& to, const mapless::SE3& T) {
  set(to.position, T.translation());
  set(to.orientation, T.rotation());
}

template <class Vector>
Eigen::Vector3d vector_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

template <class Vector>
mapless::SE3 transform_of(const Vector& translation, const geometry_msgs::msg::Quaternion& q) {
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(), vector_of(translation)};
}

visualization_msgs::msg::Marker marker_of(const mapless::LiveOutput& output,
                                          const mapless::LiveObject& object, const char* ns, int type) {
  visualization_msgs::msg::Marker marker;
  marker.header.stamp = stamp_of(output.labelled.scan().start);
  marker.header.frame_id = output.world_frame;
  marker.ns = ns;
  marker.id = static_cast<std::int32_t>(object.id);
  marker.type = type;
  marker.pose.orientation.w = 1;
  marker.color.r = 1;
  marker.color.g = 0.2F;
  marker.color.a = 0.6F;
  marker.lifetime.nanosec = 500'000'000;
  return marker;
}

}  // namespace

mapless::Time time_of(const builtin_interfaces::msg::Time& stamp) {
  return mapless::Time::from_nanoseconds(stamp.sec * kNanosecondsPerSecond + stamp.nanosec);
}

void add_transforms(mapless::LiveDetector& live, const tf2_msgs::msg::TFMessage& message, bool is_static) {
  for (const auto& one : message.transforms) {
    live.add_transform(one.header.frame_id, one.child_frame_id, time_of(one.header.stamp),
                       transform_of(one.transform.translation, one.transform.rotation), is_static);
  }
}

void add_pose(mapless::LiveDetector& live, const nav_msgs::msg::Odometry& message,
              const std::string& world_frame) {
  live.add_transform(world_frame, message.child_frame_id, time_of(message.header.stamp),
                     transform_of(message.pose.pose.position, message.pose.pose.orientation), false);
}

void add_imu(mapless::LiveDetector& live, const sensor_msgs::msg::Imu& message) {
  live.add_angular_velocity(message.header.frame_id, time_of(message.header.stamp),
                            vector_of(message.angular_velocity));
}

void add_wheels(mapless::LiveDetector& live, const nav_msgs::msg::Odometry& message) {
  live.add_twist(message.child_frame_id, time_of(message.header.stamp), vector_of(message.twist.twist.linear),
                 vector_of(message.twist.twist.angular));
}

mapless::PointCloud2 cloud_of(const sensor_msgs::msg::PointCloud2::ConstSharedPtr& message) {
  mapless::PointCloud2 cloud;
  cloud.view.stamp = time_of(message->header.stamp);
  cloud.view.frame_id = message->header.frame_id;
  cloud.view.height = message->height;
  cloud.view.width = message->width;
  for (const auto& field : message->fields)
    cloud.view.fields.push_back({field.name, field.offset, field.datatype, field.count});
  cloud.view.is_bigendian = message->is_bigendian;
  cloud.view.point_step = message->point_step;
  cloud.view.row_step = message->row_step;
  // Not the vector itself: later releases than Kilted have a buffer of their own here.
  cloud.view.data = {message->data.data(), message->data.size()};
  cloud.owner = message;
  return cloud;
}

sensor_msgs::msg::PointCloud2::UniquePtr cloud_message(const mapless::PointCloud2& cloud) {
  const mapless::PointCloud2View& view = cloud.view;
  auto message = std::make_unique<sensor_msgs::msg::PointCloud2>();
  message->header.stamp = stamp_of(view.stamp);
  message->header.frame_id = view.frame_id;
  message->height = view.height;
  message->width = view.width;
  for (const mapless::PointCloud2Field& from : view.fields) {
    auto& field = message->fields.emplace_back();
    field.name = from.name;
    field.offset = from.offset;
    field.datatype = from.datatype;
    field.count = from.count;
  }
  message->is_bigendian = view.is_bigendian;
  message->point_step = view.point_step;
  message->row_step = view.row_step;
  message->data.assign(view.data.begin(), view.data.end());
  return message;
}

nav_msgs::msg::Odometry odometry_message(const mapless::LiveOdometry& odometry,
                                         const std::string& world_frame, const std::string& body_frame) {
  nav_msgs::msg::Odometry message;
  message.header.stamp = stamp_of(odometry.time);
  message.header.frame_id = world_frame;
  message.child_frame_id = body_frame;
  set(message.pose.pose, odometry.T_wb);
  set(message.twist.twist.linear, odometry.velocity_b.head<3>());
  set(message.twist.twist.angular, odometry.velocity_b.tail<3>());
  for (int i = 0; i < 36; ++i) {
    const auto k = static_cast<std::size_t>(i);
    message.pose.covariance[k] = odometry.pose_covariance_w(i / 6, i % 6);
    message.twist.covariance[k] = odometry.velocity_covariance_b(i / 6, i % 6);
  }
  return message;
}

tf2_msgs::msg::TFMessage transforms_message(const std::vector<mapless::LiveTransform>& transforms) {
  tf2_msgs::msg::TFMessage message;
  for (const mapless::LiveTransform& transform : transforms) {
    auto& stamped = message.transforms.emplace_back();
    stamped.header.stamp = stamp_of(transform.time);
    stamped.header.frame_id = transform.parent;
    stamped.child_frame_id = transform.child;
    set(stamped.transform.translation, transform.T_parent_child.translation());
    set(stamped.transform.rotation, transform.T_parent_child.rotation());
  }
  return message;
}

diagnostic_msgs::msg::DiagnosticStatus status_message(const mapless::LiveDiagnostics& diagnostics,
                                                      const std::string& name) {
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = static_cast<std::uint8_t>(diagnostics.level);
  status.name = name;
  status.message = diagnostics.message;
  status.hardware_id = diagnostics.sensor;
  for (const auto& [key, value] : diagnostics.values) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = value;
  }
  return status;
}

vision_msgs::msg::Detection3DArray objects_message(const mapless::LiveOutput& output) {
  vision_msgs::msg::Detection3DArray message;
  message.header.stamp = stamp_of(output.labelled.scan().start);
  message.header.frame_id = output.world_frame;
  for (const mapless::LiveObject& object : mapless::live_objects(output)) {
    auto& detection = message.detections.emplace_back();
    detection.header = message.header;
    detection.header.stamp = stamp_of(object.time);
    detection.id = std::to_string(object.id);
    set(detection.bbox.center, {object.rotation_wb, object.centre_w});
    set(detection.bbox.size, object.extent_b);
    auto& result = detection.results.emplace_back();
    result.hypothesis.class_id = "moving";
    result.hypothesis.score = 1;
    result.pose.pose = detection.bbox.center;
  }
  return message;
}

// As markers_message of mapless live: a box, an arrow along the velocity, id and speed.
visualization_msgs::msg::MarkerArray markers_message(const mapless::LiveOutput& output) {
  using visualization_msgs::msg::Marker;
  visualization_msgs::msg::MarkerArray message;
  message.markers.push_back(marker_of(output, {}, "boxes", Marker::CUBE));
  message.markers.back().action = Marker::DELETEALL;
  for (const mapless::LiveObject& object : mapless::live_objects(output)) {
    Marker box = marker_of(output, object, "boxes", Marker::CUBE);
    set(box.pose, {object.rotation_wb, object.centre_w});
    set(box.scale, object.extent_b);
    Marker arrow = marker_of(output, object, "velocities", Marker::ARROW);
    set(arrow.points.emplace_back(), object.centre_w);
    set(arrow.points.emplace_back(), object.centre_w + object.velocity_w);
    set(arrow.scale, {0.1, 0.25, 0});
    Marker label = marker_of(output, object, "labels", Marker::TEXT_VIEW_FACING);
    set(label.pose.position, object.centre_w + Eigen::Vector3d(0, 0, object.extent_b.z() / 2 + 0.5));
    label.scale.z = 0.5;
    label.text = fmt::format("{}: {:.1f} m/s", object.id, object.velocity_w.norm());
    for (Marker& marker : {std::ref(box), std::ref(arrow), std::ref(label)})
      message.markers.push_back(marker);
  }
  return message;
}

}  // namespace mapless_ros
