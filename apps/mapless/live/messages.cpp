#include "live/messages.hpp"

#include <algorithm>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace mapless::app {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
// visualization_msgs/Marker
constexpr std::int32_t kArrow = 0, kCube = 1, kText = 9;
constexpr std::int32_t kAdd = 0, kDeleteAll = 3;
constexpr double kArrowShaft_m = 0.1, kArrowHead_m = 0.25, kTextHeight_m = 0.5;

builtin_interfaces_msg_dds__Time_ stamp_of(Time time) {
  std::int64_t seconds = time.nanoseconds() / kNanosecondsPerSecond;
  std::int64_t rest = time.nanoseconds() % kNanosecondsPerSecond;
  if (rest < 0) {
    rest += kNanosecondsPerSecond;
    --seconds;
  }
  return {static_cast<std::int32_t>(seconds), static_cast<std::uint32_t>(rest)};
}

template <class Message>
std_msgs_msg_dds__Header_ header_of(OwnedMessage<Message>& owner, Time time, const std::string& frame) {
  return {stamp_of(time), owner.text(frame)};
}

template <class Vector>
Vector vector_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

geometry_msgs_msg_dds__Quaternion_ quaternion_of(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {q.x(), q.y(), q.z(), q.w()};
}

geometry_msgs_msg_dds__Pose_ pose_of(const SE3& T) {
  return {vector_of<geometry_msgs_msg_dds__Point_>(T.translation()), quaternion_of(T.rotation())};
}

// ROS writes covariances row by row.
void copy_covariance(const Matrix6d& from, double (&to)[36]) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) to[6 * row + column] = from(row, column);
  }
}

SE3 transform_of(const Eigen::Vector3d& translation, const geometry_msgs_msg_dds__Quaternion_& q) {
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(), translation};
}

visualization_msgs_msg_dds__Marker_ empty_marker(MarkersMessage& owner, const LiveOutput& output,
                                                 const char* ns, std::int32_t type) {
  visualization_msgs_msg_dds__Marker_ marker = {};
  marker.header = header_of(owner, output.labelled.scan().start, output.world_frame);
  marker.ns = owner.text(ns);
  marker.type = type;
  marker.action = kAdd;
  marker.pose.orientation.w = 1;
  marker.color = {1, 0.2F, 0.1F, 0.6F};
  marker.lifetime = {0, 500'000'000};  // longer than a turn at 5 Hz, and gone soon where labels end
  marker.texture.header = header_of(owner, Time(), "");
  for (char** text : {&marker.texture_resource, &marker.texture.format, &marker.text, &marker.mesh_resource,
                      &marker.mesh_file.filename})
    *text = owner.text("");
  return marker;
}

void add_markers(MarkersMessage& owner, const LiveOutput& output, const LiveObject& object,
                 std::vector<visualization_msgs_msg_dds__Marker_>& markers) {
  using Point = geometry_msgs_msg_dds__Point_;
  auto box = empty_marker(owner, output, "boxes", kCube);
  box.pose = pose_of({object.rotation_wb, object.centre_w});
  box.scale = vector_of<geometry_msgs_msg_dds__Vector3_>(object.extent_b);
  auto arrow = empty_marker(owner, output, "velocities", kArrow);
  owner.set(arrow.points, std::vector<Point>{vector_of<Point>(object.centre_w),
                                             vector_of<Point>(object.centre_w + object.velocity_w)});
  arrow.scale = {kArrowShaft_m, kArrowHead_m, 0};
  auto label = empty_marker(owner, output, "labels", kText);
  label.pose.position =
      vector_of<Point>(object.centre_w + Eigen::Vector3d(0, 0, object.extent_b.z() / 2 + kTextHeight_m));
  label.scale.z = kTextHeight_m;
  label.text = owner.text(fmt::format("{}: {:.1f} m/s", object.id, object.velocity_w.norm()));
  for (auto* marker : {&box, &arrow, &label}) {
    marker->id = static_cast<std::int32_t>(object.id);
    markers.push_back(*marker);
  }
}

}  // namespace

Eigen::Vector3d vector_of(const geometry_msgs_msg_dds__Vector3_& v) { return {v.x, v.y, v.z}; }

Time time_of(const builtin_interfaces_msg_dds__Time_& stamp) {
  return Time::from_nanoseconds(stamp.sec * kNanosecondsPerSecond + stamp.nanosec);
}

SE3 transform_of(const geometry_msgs_msg_dds__Transform_& transform) {
  const auto& t = transform.translation;
  return transform_of({t.x, t.y, t.z}, transform.rotation);
}

SE3 transform_of(const geometry_msgs_msg_dds__Pose_& pose) {
  const auto& p = pose.position;
  return transform_of({p.x, p.y, p.z}, pose.orientation);
}

PointCloud2 cloud_of(const std::shared_ptr<const sensor_msgs_msg_dds__PointCloud2_>& message) {
  PointCloud2 cloud;
  PointCloud2View& view = cloud.view;
  view.stamp = time_of(message->header.stamp);
  view.frame_id = message->header.frame_id;
  view.height = message->height;
  view.width = message->width;
  for (std::uint32_t i = 0; i < message->fields._length; ++i) {
    const auto& field = message->fields._buffer[i];
    view.fields.push_back({field.name, field.offset, field.datatype, field.count});
  }
  view.is_bigendian = message->is_bigendian;
  view.point_step = message->point_step;
  view.row_step = message->row_step;
  view.data = {message->data._buffer, message->data._length};
  cloud.owner = message;
  return cloud;
}

CloudMessage cloud_message(const PointCloud2& cloud) {
  const PointCloud2View& view = cloud.view;
  CloudMessage out;
  auto& message = out.message;
  message.header = header_of(out, view.stamp, view.frame_id);
  message.height = view.height;
  message.width = view.width;
  std::vector<sensor_msgs_msg_dds__PointField_> fields;
  for (const PointCloud2Field& field : view.fields)
    fields.push_back({out.text(field.name), field.offset, field.datatype, field.count});
  out.set(message.fields, std::move(fields));
  message.is_bigendian = view.is_bigendian;
  message.point_step = view.point_step;
  message.row_step = view.row_step;
  // Writing does not change them; C has no const here.
  message.data._buffer = const_cast<std::uint8_t*>(view.data.data());
  message.data._length = message.data._maximum = static_cast<std::uint32_t>(view.data.size());
  return out;
}

OdometryMessage odometry_message(const LiveOdometry& odometry, const std::string& world_frame,
                                 const std::string& body_frame) {
  OdometryMessage out;
  auto& message = out.message;
  message.header = header_of(out, odometry.time, world_frame);
  message.child_frame_id = out.text(body_frame);
  message.pose.pose = pose_of(odometry.T_wb);
  copy_covariance(odometry.pose_covariance_w, message.pose.covariance);
  using Vector = geometry_msgs_msg_dds__Vector3_;
  message.twist.twist = {vector_of<Vector>(odometry.velocity_b.head<3>()),
                         vector_of<Vector>(odometry.velocity_b.tail<3>())};
  copy_covariance(odometry.velocity_covariance_b, message.twist.covariance);
  return out;
}

TransformMessage transforms_message(const std::vector<LiveTransform>& transforms) {
  TransformMessage out;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> stamped;
  for (const LiveTransform& transform : transforms) {
    auto& one = stamped.emplace_back();
    one.header = header_of(out, transform.time, transform.parent);
    one.child_frame_id = out.text(transform.child);
    one.transform = {vector_of<geometry_msgs_msg_dds__Vector3_>(transform.T_parent_child.translation()),
                     quaternion_of(transform.T_parent_child.rotation())};
  }
  out.set(out.message.transforms, std::move(stamped));
  return out;
}

DiagnosticsMessage diagnostics_message(const LiveDiagnostics& diagnostics, Time now) {
  DiagnosticsMessage out;
  std::vector<diagnostic_msgs_msg_dds__KeyValue_> values;
  for (const auto& [key, value] : diagnostics.values) values.push_back({out.text(key), out.text(value)});
  diagnostic_msgs_msg_dds__DiagnosticStatus_ status = {};
  status.level = static_cast<std::uint8_t>(diagnostics.level);
  status.name = out.text("mapless: labels");
  status.message = out.text(diagnostics.message);
  status.hardware_id = out.text(diagnostics.sensor);
  out.set(status.values, std::move(values));
  out.message.header = header_of(out, now, "");
  out.set(out.message.status, std::vector{status});
  return out;
}

ObjectsMessage objects_message(const LiveOutput& output) {
  ObjectsMessage out;
  std::vector<vision_msgs_msg_dds__Detection3D_> detections;
  for (const LiveObject& object : live_objects(output)) {
    vision_msgs_msg_dds__Detection3D_ detection = {};
    detection.header = header_of(out, object.time, output.world_frame);
    detection.bbox = {pose_of({object.rotation_wb, object.centre_w}),
                      vector_of<geometry_msgs_msg_dds__Vector3_>(object.extent_b)};
    detection.id = out.text(std::to_string(object.id));
    vision_msgs_msg_dds__ObjectHypothesisWithPose_ moving = {};
    moving.hypothesis = {out.text("moving"), 1};
    moving.pose.pose = detection.bbox.center;
    out.set(detection.results, std::vector{moving});
    detections.push_back(detection);
  }
  out.message.header = header_of(out, output.labelled.scan().start, output.world_frame);
  out.set(out.message.detections, std::move(detections));
  return out;
}

MarkersMessage markers_message(const LiveOutput& output) {
  MarkersMessage out;
  std::vector<visualization_msgs_msg_dds__Marker_> markers = {empty_marker(out, output, "boxes", kCube)};
  markers.front().action = kDeleteAll;  // the objects of the scan before
  for (const LiveObject& object : live_objects(output)) add_markers(out, output, object, markers);
  out.set(out.message.markers, std::move(markers));
  return out;
}

}  // namespace mapless::app
