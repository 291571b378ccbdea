// Labels the clouds of a bag, as fast as the computer can and with none dropped, and writes them to another
// bag:
//   ros2 run mapless_ros label_bag IN OUT TOPIC [--ros-args --params-file labeller.yaml]
// Motion is the own odometry, or the transforms or the odometry of the bag (parameter motion). The topics
// odometry_in, imu and wheel_odometry can be remapped as those of the node: -r imu:=/imu/data.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <rclcpp/serialization.hpp>
#include <rosbag2_cpp/reader.hpp>
#include <rosbag2_cpp/writer.hpp>
#include <rosbag2_storage/storage_options.hpp>

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

std::string topics_of(const rosbag2_cpp::Reader& reader) {
  std::string names;
  for (const auto& topic : reader.get_all_topics_and_types()) {
    if (topic.type == "sensor_msgs/msg/PointCloud2") names += (names.empty() ? "" : ", ") + topic.name;
  }
  return names.empty() ? "none" : names;
}

// The plugin by the names of the bag's files: where none is named, Humble takes sqlite3 for MCAP, too.
rosbag2_storage::StorageOptions storage_of(const std::string& bag) {
  namespace fs = std::filesystem;
  rosbag2_storage::StorageOptions storage;
  storage.uri = bag;
  std::vector<fs::path> files{bag};
  if (fs::is_directory(bag)) files.assign(fs::directory_iterator(bag), fs::directory_iterator());
  for (const fs::path& file : files) {
    if (file.extension() == ".mcap") storage.storage_id = "mcap";
    if (file.extension() == ".db3") storage.storage_id = "sqlite3";
  }
  return storage;
}

struct Topics {
  std::string points, poses, imu, wheels;
};

class BagLabeller {
 public:
  BagLabeller(const mapless::LiveOptions& options, const Topics& topics, const std::string& out)
      : options_(options), topics_(topics), live_(options, [this] { return now_; }) {
    writer_.open(out);
  }

  void run(const std::string& in) {
    rosbag2_cpp::Reader reader;
    reader.open(storage_of(in), rosbag2_cpp::ConverterOptions());
    while (rclcpp::ok() && reader.has_next()) take(*reader.read_next());
    if (clouds_ == 0) {
      throw std::runtime_error(in + ": no clouds on topic " + topics_.points +
                               "; topics of clouds: " + topics_of(reader));
    }
    write(live_.process());
    write(live_.reset());
    for (const mapless::LiveEvent& event : live_.take_events())
      std::fprintf(stderr, "%s\n", event.text.c_str());
    std::fprintf(stderr, "%zu of %zu clouds labelled\n", labelled_, clouds_);
    if (!rclcpp::ok()) throw std::runtime_error(in + ": interrupted before its end");
  }

 private:
  void take(const rosbag2_storage::SerializedBagMessage& stored) {
    using nav_msgs::msg::Odometry;
    using sensor_msgs::msg::Imu;
    using tf2_msgs::msg::TFMessage;
    const std::string& topic = stored.topic_name;
    const mapless::LiveMotion motion = options_.live.motion;
    if (topic == topics_.points) {
      label(message_of<sensor_msgs::msg::PointCloud2>(stored));
    } else if (topic == "/tf_static" || (motion == mapless::LiveMotion::tf && topic == "/tf")) {
      mapless_ros::add_transforms(live_, *message_of<TFMessage>(stored), topic == "/tf_static");
    } else if (motion == mapless::LiveMotion::odometry && topic == topics_.poses) {
      mapless_ros::add_pose(live_, *message_of<Odometry>(stored), options_.world_frame);
    } else if (options_.live.use_imu && topic == topics_.imu) {
      mapless_ros::add_imu(live_, *message_of<Imu>(stored));
    } else if (options_.live.use_wheel_odometry && topic == topics_.wheels) {
      mapless_ros::add_wheels(live_, *message_of<Odometry>(stored));
    }
  }

  void label(const sensor_msgs::msg::PointCloud2::ConstSharedPtr& cloud) {
    ++clouds_;
    now_ = mapless_ros::time_of(cloud->header.stamp);
    live_.add_cloud(mapless_ros::cloud_of(cloud));
    write(live_.process());
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
      ++labelled_;
    }
  }

  mapless::LiveOptions options_;
  Topics topics_;
  mapless::Time now_;
  mapless::LiveDetector live_;
  rosbag2_cpp::Writer writer_;
  std::size_t clouds_ = 0, labelled_ = 0;
};

}  // namespace

int main(int argc, char** argv) try {
  const auto arguments = rclcpp::init_and_remove_ros_arguments(argc, argv);
  if (arguments.size() != 4) return std::fputs("usage: label_bag IN OUT TOPIC [--ros-args ...]\n", stderr), 2;
  mapless::LiveOptions options;
  rclcpp::Node node("labeller");
  mapless_ros::declare_parameters(node, options);
  const auto resolved = [&node](const char* name) {
    return node.get_node_topics_interface()->resolve_topic_name(name);
  };
  const Topics topics{arguments[3], resolved("odometry_in"), resolved("imu"), resolved("wheel_odometry")};
  BagLabeller(options, topics, arguments[2]).run(arguments[1]);
  rclcpp::shutdown();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "label_bag: error: %s\n", error.what());
  return 1;
}
