#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "live/dds_entities.hpp"
#include <mapless/live/live_detector.hpp>

namespace mapless::app {

/// Settings of a LiveNode beside those of its LiveDetector.
struct LiveNodeOptions {
  LiveOptions live;
  std::string odometry_topic = "odometry_in";
  std::string imu_topic = "imu";
  std::string wheel_odometry_topic = "wheel_odometry";
  std::string prefix;  ///< of the topics written and of the services: "mapless/"
  std::uint32_t domain = 0;
};

/// A LiveDetector on DDS, with the topics, types and quality of service of ROS 2.
class LiveNode {
 public:
  explicit LiveNode(const LiveNodeOptions& options);

  /// Reads, labels and writes until `stop` returns true. Throws Error where the middleware fails.
  void run(const std::function<bool()>& stop);
  [[nodiscard]] LiveDiagnostics diagnostics() const { return live_.diagnostics(); }

 private:
  void read_all(const std::atomic<bool>& stop);
  void read_once();
  void read_measurements();
  void read_requests();
  void add_transforms(const tf2_msgs_msg_dds__TFMessage_& message, bool is_static);
  void publish(const std::vector<LiveOutput>& outputs);
  void publish_one(const LiveOutput& output);
  void label();
  void publish_odometry(const LiveOutput& output);
  void publish_diagnostics();

  template <class Message>
  using Reader = DdsReader<Message>;
  template <class Message>
  using Writer = DdsWriter<Message>;
  using Cloud = sensor_msgs_msg_dds__PointCloud2_;
  using Transforms = tf2_msgs_msg_dds__TFMessage_;

  LiveNodeOptions options_;
  int diagnostics_count_ = 0;
  LiveDetector live_;
  DdsParticipant participant_;
  Reader<Cloud> points_;
  std::optional<Reader<Transforms>> tf_, tf_static_;
  std::optional<Reader<nav_msgs_msg_dds__Odometry_>> odometry_in_, wheels_;
  std::optional<Reader<sensor_msgs_msg_dds__Imu_>> imu_;
  Writer<Cloud> labelled_, static_, moving_;
  Writer<vision_msgs_msg_dds__Detection3DArray_> objects_;
  Writer<visualization_msgs_msg_dds__MarkerArray_> markers_;
  Writer<nav_msgs_msg_dds__Odometry_> odometry_;
  Writer<std_msgs_msg_dds__Float64_> processing_time_;
  Writer<diagnostic_msgs_msg_dds__DiagnosticArray_> diagnostics_;
  std::optional<Writer<Transforms>> tf_out_;
  DdsService<std_srvs_srv_dds__Empty_Request_, std_srvs_srv_dds__Empty_Response_> reset_;
  DdsService<std_srvs_srv_dds__Trigger_Request_, std_srvs_srv_dds__Trigger_Response_> save_static_map_;
  std::atomic<bool> reset_wanted_{false};
  StaticMap static_map_;  // after the service that its thread replies by
};

}  // namespace mapless::app
