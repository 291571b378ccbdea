#pragma once

// The part of the interface of ROS 2 that ros2/mapless_ros uses, as the headers of Humble and of later
// releases declare it, so that its sources can be checked where ROS 2 is not installed. Nothing here does
// anything.

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#define STUB_MESSAGE(name)                            \
  using SharedPtr = std::shared_ptr<name>;            \
  using ConstSharedPtr = std::shared_ptr<const name>; \
  using UniquePtr = std::unique_ptr<name>

namespace builtin_interfaces::msg {
struct Time {
  std::int32_t sec;
  std::uint32_t nanosec;
};
struct Duration {
  std::int32_t sec;
  std::uint32_t nanosec;
};
}
namespace std_msgs::msg {
struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};
struct ColorRGBA {
  float r, g, b, a;
};
struct Float64 {
  double data;
};
}
namespace geometry_msgs::msg {
struct Point {
  double x, y, z;
};
struct Vector3 {
  double x, y, z;
};
struct Quaternion {
  double x, y, z, w;
};
struct Pose {
  Point position;
  Quaternion orientation;
};
struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance;
};
struct Twist {
  Vector3 linear, angular;
};
struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance;
};
struct Transform {
  Vector3 translation;
  Quaternion rotation;
};
struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};
}
namespace sensor_msgs::msg {
struct PointField {
  std::string name;
  std::uint32_t offset;
  std::uint8_t datatype;
  std::uint32_t count;
};
struct Imu {
  STUB_MESSAGE(Imu);
  std_msgs::msg::Header header;
  geometry_msgs::msg::Vector3 angular_velocity;
};
struct PointCloud2 {
  STUB_MESSAGE(PointCloud2);
  std_msgs::msg::Header header;
  std::uint32_t height, width;
  std::vector<PointField> fields;
  bool is_bigendian;
  std::uint32_t point_step, row_step;
  std::vector<std::uint8_t> data;
  bool is_dense;
};
}
namespace nav_msgs::msg {
struct Odometry {
  STUB_MESSAGE(Odometry);
  std_msgs::msg::Header header;
  std::string child_frame_id;
  geometry_msgs::msg::PoseWithCovariance pose;
  geometry_msgs::msg::TwistWithCovariance twist;
};
}
namespace tf2_msgs::msg {
struct TFMessage {
  STUB_MESSAGE(TFMessage);
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
};
}
namespace diagnostic_msgs::msg {
struct KeyValue {
  std::string key, value;
};
struct DiagnosticStatus {
  std::uint8_t level;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
};
struct DiagnosticArray {
  std_msgs::msg::Header header;
  std::vector<DiagnosticStatus> status;
};
}
namespace visualization_msgs::msg {
struct Marker {
  enum : std::int32_t { ARROW = 0, CUBE = 1, TEXT_VIEW_FACING = 9, ADD = 0, DELETEALL = 3 };
  std_msgs::msg::Header header;
  std::string ns;
  std::int32_t id, type, action;
  geometry_msgs::msg::Pose pose;
  geometry_msgs::msg::Vector3 scale;
  std_msgs::msg::ColorRGBA color;
  builtin_interfaces::msg::Duration lifetime;
  std::vector<geometry_msgs::msg::Point> points;
  std::string text;
};
struct MarkerArray {
  std::vector<Marker> markers;
};
}
namespace vision_msgs::msg {
struct ObjectHypothesis {
  std::string class_id;
  double score;
};
struct ObjectHypothesisWithPose {
  ObjectHypothesis hypothesis;
  geometry_msgs::msg::PoseWithCovariance pose;
};
struct BoundingBox3D {
  geometry_msgs::msg::Pose center;
  geometry_msgs::msg::Vector3 size;
};
struct Detection3D {
  std_msgs::msg::Header header;
  std::vector<ObjectHypothesisWithPose> results;
  BoundingBox3D bbox;
  std::string id;
};
struct Detection3DArray {
  std_msgs::msg::Header header;
  std::vector<Detection3D> detections;
};
}
namespace std_srvs::srv {
struct Empty {
  struct Request {
    STUB_MESSAGE(Request);
  };
  struct Response {
    STUB_MESSAGE(Response);
  };
};
struct Trigger {
  struct Request {
    STUB_MESSAGE(Request);
  };
  struct Response {
    STUB_MESSAGE(Response);
    bool success;
    std::string message;
  };
};
}
namespace rcl_interfaces::msg {
struct ParameterDescriptor {
  std::string name, description;
  bool read_only, dynamic_typing;
};
}
struct rcl_serialized_message_t {};
struct rmw_request_id_t {};
struct rmw_gid_t {
  const char* implementation_identifier;
  std::uint8_t data[24];
};
struct rmw_message_info_t {
  rmw_gid_t publisher_gid;
};

namespace rclcpp {
enum ParameterType : std::uint8_t {
  PARAMETER_NOT_SET,
  PARAMETER_BOOL,
  PARAMETER_INTEGER,
  PARAMETER_DOUBLE,
  PARAMETER_STRING
};
class ParameterValue {
 public:
  explicit ParameterValue(bool);
  explicit ParameterValue(int);
  explicit ParameterValue(std::int64_t);
  explicit ParameterValue(float);
  explicit ParameterValue(double);
  explicit ParameterValue(const std::string&);
  explicit ParameterValue(const char*);
  [[nodiscard]] ParameterType get_type() const;
  template <class T>
  [[nodiscard]] const T& get() const;
};
std::string to_string(const ParameterValue&);
class MessageInfo {
 public:
  [[nodiscard]] const rmw_message_info_t& get_rmw_message_info() const;
};
struct KeepLast {
  explicit KeepLast(std::size_t depth);
};
class QoS {
 public:
  QoS(const KeepLast&);
  QoS& reliable();
  QoS& best_effort();
  QoS& transient_local();
};
struct SensorDataQoS : QoS {
  SensorDataQoS();
};
struct QosOverridingOptions {
  static QosOverridingOptions with_default_policies(std::function<void()> validation = nullptr,
                                                    std::string id = {});
};
enum class IntraProcessSetting { Enable, Disable, NodeDefault };
struct SubscriptionOptions {
  IntraProcessSetting use_intra_process_comm = IntraProcessSetting::NodeDefault;
  QosOverridingOptions qos_overriding_options;
};
struct PublisherOptions {
  IntraProcessSetting use_intra_process_comm = IntraProcessSetting::NodeDefault;
  QosOverridingOptions qos_overriding_options;
};
struct SubscriptionBase {
  using SharedPtr = std::shared_ptr<SubscriptionBase>;
  [[nodiscard]] const char* get_topic_name() const;
};
template <class M>
struct Subscription : SubscriptionBase {};
template <class M>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher<M>>;
  void publish(std::unique_ptr<M>);
  void publish(const M&);
  [[nodiscard]] std::size_t get_subscription_count() const;
  [[nodiscard]] std::size_t get_intra_process_subscription_count() const;
};
struct ServiceBase {
  using SharedPtr = std::shared_ptr<ServiceBase>;
};
template <class S>
struct Service : ServiceBase {
  using SharedPtr = std::shared_ptr<Service<S>>;
  void send_response(rmw_request_id_t&, typename S::Response&);
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
};
struct WallTimer : TimerBase {};
struct Logger {};
struct Time {
  Time(const builtin_interfaces::msg::Time&);
  operator builtin_interfaces::msg::Time() const;
};
struct NodeOptions {};
class TopicEndpointInfo {
 public:
  [[nodiscard]] const std::string& node_name() const;
  [[nodiscard]] const std::string& node_namespace() const;
  [[nodiscard]] const std::string& topic_type() const;
};
struct NodeTopicsInterface {
  [[nodiscard]] std::string resolve_topic_name(const std::string& name, bool only_expand = false) const;
};
struct NodeParametersInterface {
  [[nodiscard]] const std::map<std::string, ParameterValue>& get_parameter_overrides() const;
};
class Node {
 public:
  explicit Node(const std::string& name, const NodeOptions& = NodeOptions());
  virtual ~Node();
  const ParameterValue& declare_parameter(const std::string&, const ParameterValue&,
                                          const rcl_interfaces::msg::ParameterDescriptor& = {},
                                          bool ignore = false);
  [[nodiscard]] bool has_parameter(const std::string&) const;
  [[nodiscard]] std::shared_ptr<NodeParametersInterface> get_node_parameters_interface();
  [[nodiscard]] std::shared_ptr<NodeTopicsInterface> get_node_topics_interface();
  [[nodiscard]] const char* get_name() const;
  [[nodiscard]] const char* get_fully_qualified_name() const;
  [[nodiscard]] const char* get_namespace() const;
  [[nodiscard]] std::map<std::string, std::vector<std::string>> get_topic_names_and_types() const;
  [[nodiscard]] std::vector<TopicEndpointInfo> get_publishers_info_by_topic(const std::string&,
                                                                            bool no_mangle = false) const;
  [[nodiscard]] Logger get_logger() const;
  [[nodiscard]] Time now() const;
  template <class M>
  std::shared_ptr<Publisher<M>> create_publisher(const std::string&, const QoS&,
                                                 const PublisherOptions& = {});
  template <class M>
  std::shared_ptr<Subscription<M>> create_subscription(
      const std::string&, const QoS&, std::function<void(std::shared_ptr<const M>, const MessageInfo&)>,
      const SubscriptionOptions& = {});
  template <class M>
  std::shared_ptr<Subscription<M>> create_subscription(const std::string&, const QoS&,
                                                       std::function<void(std::shared_ptr<const M>)>,
                                                       const SubscriptionOptions& = {});
  template <class S>
  std::shared_ptr<Service<S>> create_service(
      const std::string&,
      std::function<void(std::shared_ptr<typename S::Request>, std::shared_ptr<typename S::Response>)>);
  template <class S>
  std::shared_ptr<Service<S>> create_service(
      const std::string&,
      std::function<void(std::shared_ptr<rmw_request_id_t>, std::shared_ptr<typename S::Request>)>);
  template <class P>
  std::shared_ptr<WallTimer> create_wall_timer(P period, std::function<void()>);
};
class SerializedMessage {
 public:
  explicit SerializedMessage(std::size_t initial_capacity);
  explicit SerializedMessage(const rcl_serialized_message_t&);
};
template <class M>
struct Serialization {
  void deserialize_message(const SerializedMessage*, void*) const;
};
std::vector<std::string> init_and_remove_ros_arguments(int argc, char const* const* argv);
bool ok(std::shared_ptr<void> context = nullptr);
bool shutdown(std::shared_ptr<void> context = nullptr,
              const std::string& reason = "user called rclcpp::shutdown()");
}
namespace rosbag2_storage {
struct TopicMetadata {
  std::string name, type;
};
struct StorageOptions {
  std::string uri, storage_id;
};
struct SerializedBagMessage {
  std::shared_ptr<rcl_serialized_message_t> serialized_data;
  std::string topic_name;
};
}
namespace rosbag2_cpp {
struct ConverterOptions {
  std::string input_serialization_format, output_serialization_format;
};
class Reader {
 public:
  void open(const std::string&);
  void open(const rosbag2_storage::StorageOptions&, const ConverterOptions& = ConverterOptions());
  bool has_next();
  [[nodiscard]] std::vector<rosbag2_storage::TopicMetadata> get_all_topics_and_types() const;
  std::shared_ptr<rosbag2_storage::SerializedBagMessage> read_next();
};
class Writer {
 public:
  void open(const std::string&);
  template <class M>
  void write(const M&, const std::string&, const rclcpp::Time&);
};
}
void stub_log(const rclcpp::Logger&, const char*, const char*);
#define RCLCPP_ERROR(logger, format, text) stub_log(logger, format, text)
#define RCLCPP_WARN(logger, format, text) stub_log(logger, format, text)
#define RCLCPP_INFO(logger, format, text) stub_log(logger, format, text)
#define RCLCPP_COMPONENTS_REGISTER_NODE(type) \
  static_assert(sizeof(std::make_unique<type>(rclcpp::NodeOptions())) > 0);
