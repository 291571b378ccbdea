// Labels the clouds of a bag, as fast as the computer can and with none dropped, and writes them to another
// bag:
//   ros2 run mapless_ros label_bag IN OUT TOPIC [--ros-args --params-file labeller.yaml]
// Motion is the own odometry, or the transforms of the bag (parameter motion: tf).
#include <cstdio>
#include <exception>

#include <rclcpp/serialization.hpp>
#include <rosbag2_cpp/reader.hpp>
#include <rosbag2_cpp/writer.hpp>

#include "messages.hpp"
#include "parameters.hpp"
#include <mapless/live/live_detector.hpp>

namespace {

template <class Message>
std::shared_ptr<Message> message_of(const rosbag2_storage::SerializedBagMessage& stored) {
  auto message = std::make_shared<Message>();
  rclcpp::SerializedMessage serialized(*stored.serialized_data);
  rclcpp::Serialization<Message>().deserialize_message(&serialized, message.get());
  return message;
}

class BagLabeller {
 public:
  BagLabeller(const mapless::LiveOptions& options, const std::string& out)
      : live_(options, [this] { return now_; }) {
    writer_.open(out);
  }

  void run(const std::string& in, const std::string& topic) {
    rosbag2_cpp::Reader reader;
    reader.open(in);
    while (rclcpp::ok() && reader.has_next()) {
      const auto stored = reader.read_next();
      if (stored->topic_name == "/tf" || stored->topic_name == "/tf_static")
        add_transforms(*message_of<tf2_msgs::msg::TFMessage>(*stored), stored->topic_name == "/tf_static");
      if (stored->topic_name != topic) continue;
      const auto cloud = message_of<sensor_msgs::msg::PointCloud2>(*stored);
      now_ = mapless_ros::time_of(cloud->header.stamp);
      live_.add_cloud(mapless_ros::cloud_of(cloud));
      write(live_.process());
    }
    write(live_.reset());
    for (const mapless::LiveEvent& event : live_.take_events())
      std::fprintf(stderr, "%s\n", event.text.c_str());
  }

 private:
  void add_transforms(const tf2_msgs::msg::TFMessage& message, bool is_static) {
    for (const auto& one : message.transforms) {
      live_.add_transform(one.header.frame_id, one.child_frame_id, mapless_ros::time_of(one.header.stamp),
                          mapless_ros::transform_of(one.transform), is_static);
    }
  }

  void write(const std::vector<mapless::LiveOutput>& outputs) {
    for (const mapless::LiveOutput& output : outputs) {
      const auto cloud = mapless_ros::cloud_message(mapless::labelled_cloud(output));
      const rclcpp::Time stamp(cloud->header.stamp);
      writer_.write(*cloud, "/points_labelled", stamp);
      writer_.write(mapless_ros::objects_message(output), "/objects", stamp);
      if (const auto odometry = mapless::live_odometry(output))
        writer_.write(mapless_ros::odometry_message(*odometry, output.world_frame, output.body_frame),
                      "/odometry", stamp);
    }
  }

  mapless::Time now_;
  mapless::LiveDetector live_;
  rosbag2_cpp::Writer writer_;
};

}  // namespace

int main(int argc, char** argv) try {
  const auto arguments = rclcpp::init_and_remove_ros_arguments(argc, argv);
  if (arguments.size() != 4) return std::fputs("usage: label_bag IN OUT TOPIC [--ros-args ...]\n", stderr), 2;
  mapless::LiveOptions options;
  rclcpp::Node node("labeller");
  mapless_ros::declare_parameters(node, options);
  BagLabeller(options, arguments[2]).run(arguments[1], arguments[3]);
  rclcpp::shutdown();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "label_bag: error: %s\n", error.what());
  return 1;
}
