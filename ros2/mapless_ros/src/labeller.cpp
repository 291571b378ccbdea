#include "labeller.hpp"

#include <chrono>
#include <cstring>
#include <functional>
#include <string_view>
#include <vector>

#include <rclcpp_components/register_node_macro.hpp>

#include "parameters.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless_ros {
namespace {

// How long the end of the node may take.
constexpr double kLongestWait_s = 0.1;
// Discovery takes one or two.
constexpr int kSecondsUntilHint = 3;

std::uint64_t publisher_of(const rclcpp::MessageInfo& info) {
  const auto& gid = info.get_rmw_message_info().publisher_gid.data;
  return std::hash<std::string_view>()(std::string_view(reinterpret_cast<const char*>(gid), sizeof(gid))) | 1;
}

template <class Publisher>
bool is_read(const Publisher& publisher) {
  return publisher.get_subscription_count() + publisher.get_intra_process_subscription_count() > 0;
}

rclcpp::QoS reliable() { return rclcpp::QoS(rclcpp::KeepLast(5)).reliable(); }

}  // namespace

Labeller::Labeller(const rclcpp::NodeOptions& options) : Node("labeller", options) {
  declare_parameters(*this, options_);
  live_ = std::make_unique<mapless::LiveDetector>(options_);
  static_map_ = std::make_unique<mapless::StaticMap>(options_);
  rclcpp::PublisherOptions overridable;
  overridable.qos_overriding_options = rclcpp::QosOverridingOptions::with_default_policies();
  labelled_ = create_publisher<Cloud>("points_labelled", reliable(), overridable);
  static_ = create_publisher<Cloud>("points_static", reliable(), overridable);
  moving_ = create_publisher<Cloud>("points_moving", reliable(), overridable);
  objects_ = create_publisher<vision_msgs::msg::Detection3DArray>("objects", reliable(), overridable);
  markers_ =
      create_publisher<visualization_msgs::msg::MarkerArray>("object_markers", reliable(), overridable);
  odometry_ = create_publisher<Odometry>("odometry", reliable(), overridable);
  processing_time_ =
      create_publisher<std_msgs::msg::Float64>("debug/processing_time_ms", reliable(), overridable);
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", reliable());
  if (options_.live.publish_tf)
    tf_out_ = create_publisher<Transforms>("/tf", rclcpp::QoS(rclcpp::KeepLast(100)));
  subscribe(options_.live.motion);
  serve();
  timer_ = create_wall_timer(std::chrono::seconds(1), [this] { publish_diagnostics(); });
  thread_ = std::thread([this] { label(); });
}

Labeller::~Labeller() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void Labeller::subscribe(mapless::LiveMotion motion) {
  rclcpp::SubscriptionOptions overridable;
  overridable.qos_overriding_options = rclcpp::QosOverridingOptions::with_default_policies();
  points_ = create_subscription<Cloud>(
      "points", rclcpp::SensorDataQoS(),
      [this](Cloud::ConstSharedPtr message, const rclcpp::MessageInfo& info) {
        live_->add_cloud(cloud_of(message), publisher_of(info));
      },
      overridable);
  subscribe_measurements();
  if (!options_.needs_frames()) return;
  // Humble refuses a transient local subscription within a process: the node would not start in a container.
  rclcpp::SubscriptionOptions between_processes;
  between_processes.use_intra_process_comm = rclcpp::IntraProcessSetting::Disable;
  tf_static_ = create_subscription<Transforms>(
      "/tf_static", rclcpp::QoS(rclcpp::KeepLast(100)).reliable().transient_local(),
      [this](Transforms::ConstSharedPtr message) { add_transforms(*live_, *message, true); },
      between_processes);
  if (motion == mapless::LiveMotion::tf) {
    tf_ = create_subscription<Transforms>(
        "/tf", rclcpp::QoS(rclcpp::KeepLast(100)).best_effort(),
        [this](Transforms::ConstSharedPtr message) { add_transforms(*live_, *message, false); },
        between_processes);
  } else if (motion == mapless::LiveMotion::odometry) {
    odometry_in_ = create_subscription<Odometry>(
        "odometry_in", rclcpp::SensorDataQoS(),
        [this](Odometry::ConstSharedPtr message) { add_pose(*live_, *message, options_.world_frame); });
  }
}

void Labeller::subscribe_measurements() {
  if (options_.live.use_imu) {
    imu_ = create_subscription<sensor_msgs::msg::Imu>(
        "imu", rclcpp::SensorDataQoS(),
        [this](sensor_msgs::msg::Imu::ConstSharedPtr message) { add_imu(*live_, *message); });
  }
  if (options_.live.use_wheel_odometry) {
    wheels_ = create_subscription<Odometry>(
        "wheel_odometry", rclcpp::SensorDataQoS(),
        [this](Odometry::ConstSharedPtr message) { add_wheels(*live_, *message); });
  }
}

void Labeller::serve() {
  using std_srvs::srv::Empty;
  using std_srvs::srv::Trigger;
  reset_ = create_service<Empty>("~/reset", [this](const Empty::Request::SharedPtr,
                                                   Empty::Response::SharedPtr) { reset_wanted_ = true; });
  // A callback without a response among its arguments sends the response itself, later.
  save_static_map_ = create_service<Trigger>(
      "~/save_static_map",
      [this](const std::shared_ptr<rmw_request_id_t> request, const Trigger::Request::SharedPtr) {
        static_map_->save_aside(mapless::write_cloud_file,
                                [this, request](const mapless::StaticMap::Answer& answer) {
                                  Trigger::Response response;
                                  response.success = answer.success;
                                  response.message = answer.message;
                                  save_static_map_->send_response(*request, response);
                                });
      });
}

void Labeller::label() {
  while (!stop_ && rclcpp::ok()) {
    live_->wait(mapless::Duration::from_seconds(kLongestWait_s));
    if (reset_wanted_.exchange(false)) {
      publish(live_->reset());
      static_map_->clear();
    }
    const auto began = std::chrono::steady_clock::now();
    const std::vector<mapless::LiveOutput> outputs = live_->process();
    const std::chrono::duration<double, std::milli> processing = std::chrono::steady_clock::now() - began;
    publish(outputs);
    if (outputs.empty() || !is_read(*processing_time_)) continue;
    std_msgs::msg::Float64 message;
    message.data = processing.count();
    processing_time_->publish(message);
  }
}

// The map comes last: nobody waits for it.
void Labeller::publish(const std::vector<mapless::LiveOutput>& outputs) {
  for (const mapless::LiveOutput& output : outputs) publish_one(output);
  for (const mapless::LiveOutput& output : outputs) static_map_->add(output);
}

// Nothing is made that nobody reads. The labels first, then what is small.
void Labeller::publish_one(const mapless::LiveOutput& output) {
  using mapless::PointMotion;
  if (is_read(*labelled_)) labelled_->publish(cloud_message(mapless::labelled_cloud(output)));
  publish_odometry(output);
  if (is_read(*objects_)) objects_->publish(objects_message(output));
  if (is_read(*markers_)) markers_->publish(markers_message(output));
  if (is_read(*moving_))
    moving_->publish(cloud_message(mapless::selected_cloud(output, PointMotion::moving)));
  if (is_read(*static_)) static_->publish(cloud_message(mapless::selected_cloud(output, PointMotion::still)));
}

void Labeller::publish_odometry(const mapless::LiveOutput& output) {
  const auto odometry = mapless::live_odometry(output);
  if (!odometry) return;
  const auto message = odometry_message(*odometry, output.world_frame, output.body_frame);
  if (is_read(*odometry_)) odometry_->publish(message);
  if (tf_out_)
    tf_out_->publish(transforms_message(mapless::live_transforms(output, options_.live.invert_odom_tf)));
}

void Labeller::publish_diagnostics() {
  for (const mapless::LiveEvent& event : live_->take_events()) {
    if (event.level == mapless::LiveLevel::error) {
      RCLCPP_ERROR(get_logger(), "%s", event.text.c_str());
    } else if (event.level == mapless::LiveLevel::warning) {
      RCLCPP_WARN(get_logger(), "%s", event.text.c_str());
    } else {
      RCLCPP_INFO(get_logger(), "%s", event.text.c_str());
    }
  }
  mapless::LiveDiagnostics diagnostics = live_->diagnostics();
  if (++diagnostics_count_ > kSecondsUntilHint && !diagnostics.has_clouds) {
    diagnostics.message = mapless::why_no_cloud(points_->get_topic_name(), published_topics());
    if (diagnostics_count_ == kSecondsUntilHint + 1)
      RCLCPP_WARN(get_logger(), "%s", diagnostics.message.c_str());
  }
  diagnostic_msgs::msg::DiagnosticArray message;
  message.header.stamp = now();
  message.status.push_back(status_message(diagnostics, std::string(get_fully_qualified_name()) + ": labels"));
  diagnostics_->publish(message);
}

// Of other nodes.
std::vector<mapless::PublishedTopic> Labeller::published_topics() const {
  std::vector<mapless::PublishedTopic> topics;
  for (const auto& [name, types] : get_topic_names_and_types()) {
    for (const rclcpp::TopicEndpointInfo& publisher : get_publishers_info_by_topic(name)) {
      if (publisher.node_name() == get_name() && publisher.node_namespace() == get_namespace()) continue;
      topics.push_back({name, publisher.topic_type()});
    }
  }
  return topics;
}

}  // namespace mapless_ros

RCLCPP_COMPONENTS_REGISTER_NODE(mapless_ros::Labeller)
