#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_srvs/srv/empty.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "messages.hpp"
#include <mapless/live/live_detector.hpp>

namespace mapless_ros {

/// mapless::LiveDetector as a component of ROS 2. Topics, parameters and faults: docs/ros2.md of mapless.
class Labeller : public rclcpp::Node {
 public:
  explicit Labeller(const rclcpp::NodeOptions& options);
  ~Labeller() override;

 private:
  using Cloud = sensor_msgs::msg::PointCloud2;
  using Odometry = nav_msgs::msg::Odometry;
  using Transforms = tf2_msgs::msg::TFMessage;

  void subscribe(mapless::LiveMotion motion);
  void subscribe_measurements();
  void serve();
  void label();
  void publish(const std::vector<mapless::LiveOutput>& outputs);
  void publish_one(const mapless::LiveOutput& output);
  void publish_odometry(const mapless::LiveOutput& output);
  void publish_diagnostics();
  [[nodiscard]] std::vector<mapless::PublishedTopic> published_topics() const;

  mapless::LiveOptions options_;
  std::unique_ptr<mapless::LiveDetector> live_;
  rclcpp::SubscriptionBase::SharedPtr points_, tf_, tf_static_, odometry_in_, imu_, wheels_;
  rclcpp::Publisher<Cloud>::SharedPtr labelled_, static_, moving_;
  rclcpp::Publisher<vision_msgs::msg::Detection3DArray>::SharedPtr objects_;
  rclcpp::Publisher<visualization_msgs::msg::MarkerArray>::SharedPtr markers_;
  rclcpp::Publisher<Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<std_msgs::msg::Float64>::SharedPtr processing_time_;
  rclcpp::Publisher<Transforms>::SharedPtr tf_out_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::ServiceBase::SharedPtr reset_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr save_static_map_;
  rclcpp::TimerBase::SharedPtr timer_;
  int diagnostics_count_ = 0;
  std::atomic<bool> stop_{false}, reset_wanted_{false};
  std::unique_ptr<mapless::StaticMap> static_map_;  // after the service that its thread replies by
  std::thread thread_;
};

}  // namespace mapless_ros
