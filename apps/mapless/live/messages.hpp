#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ros2_messages.h"
#include <mapless/live/live_output.hpp>

namespace mapless::app {

/// A message of ROS 2 in the C form of Cyclone DDS, with the memory that it points to.
template <class Message>
class OwnedMessage {
 public:
  Message message = {};

  /// Copies that live as long as this.
  char* text(const std::string& value) { return keep(std::string(value))->data(); }
  template <class Sequence, class Element>
  void set(Sequence& sequence, std::vector<Element> elements) {
    auto* kept = keep(std::move(elements));
    sequence._buffer = kept->data();
    sequence._length = sequence._maximum = static_cast<std::uint32_t>(kept->size());
    sequence._release = false;
  }

 private:
  template <class Value>
  Value* keep(Value value) {
    auto kept = std::make_shared<Value>(std::move(value));
    memory_.push_back(kept);
    return kept.get();
  }
  std::vector<std::shared_ptr<void>> memory_;
};

using CloudMessage = OwnedMessage<sensor_msgs_msg_dds__PointCloud2_>;
using OdometryMessage = OwnedMessage<nav_msgs_msg_dds__Odometry_>;
using TransformMessage = OwnedMessage<tf2_msgs_msg_dds__TFMessage_>;
using DiagnosticsMessage = OwnedMessage<diagnostic_msgs_msg_dds__DiagnosticArray_>;
using MarkersMessage = OwnedMessage<visualization_msgs_msg_dds__MarkerArray_>;
using ObjectsMessage = OwnedMessage<vision_msgs_msg_dds__Detection3DArray_>;

[[nodiscard]] Time time_of(const builtin_interfaces_msg_dds__Time_& stamp);
[[nodiscard]] Eigen::Vector3d vector_of(const geometry_msgs_msg_dds__Vector3_& v);
/// Parent from child.
[[nodiscard]] SE3 transform_of(const geometry_msgs_msg_dds__Transform_& transform);
[[nodiscard]] SE3 transform_of(const geometry_msgs_msg_dds__Pose_& pose);
/// Without a copy of the points.
[[nodiscard]] PointCloud2 cloud_of(const std::shared_ptr<const sensor_msgs_msg_dds__PointCloud2_>& message);

/// The message refers to the bytes of `cloud`.
[[nodiscard]] CloudMessage cloud_message(const PointCloud2& cloud);
[[nodiscard]] OdometryMessage odometry_message(const LiveOdometry& odometry, const std::string& world_frame,
                                               const std::string& body_frame);
[[nodiscard]] TransformMessage transforms_message(const std::vector<LiveTransform>& transforms);
/// `now`: Unix time.
[[nodiscard]] DiagnosticsMessage diagnostics_message(const LiveDiagnostics& diagnostics, Time now);
[[nodiscard]] ObjectsMessage objects_message(const LiveOutput& output);
/// Of each object a box, an arrow to where it is in a second, and its id and speed as text.
[[nodiscard]] MarkersMessage markers_message(const LiveOutput& output);

}  // namespace mapless::app
