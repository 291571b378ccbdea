#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <mapless/live/live_options.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::string_view kCloud = "sensor_msgs/msg/PointCloud2";

// What drivers publish beside clouds or in place of them, by a part of the name of its type.
struct OtherMessage {
  std::string_view part, remedy;
};
constexpr std::array<OtherMessage, 4> kOthers = {{
    {"livox", "a Livox lidar is not supported, because its pattern does not repeat"},
    {"LaserScan", "a lidar of one plane is not supported"},
    {"Packet", "these are packets: start the part of the driver that makes clouds of them"},
    {"VelodyneScan", "these are packets: start the part of the driver that makes clouds of them"},
}};

std::string remedy_for(const std::string& type) {
  for (const OtherMessage& other : kOthers) {
    if (type.find(other.part) != std::string::npos) return std::string(other.remedy);
  }
  return "give the topic of the clouds";
}

// What another node of mapless publishes is no cloud of a driver.
bool is_output(std::string_view name) {
  return name.ends_with("points_labelled") || name.ends_with("points_static") ||
         name.ends_with("points_moving");
}

// Names of ROS 2 begin with "/", those of the command line need not.
std::string_view without_slash(std::string_view name) {
  return name.starts_with('/') ? name.substr(1) : name;
}

}  // namespace

std::vector<std::string> cloud_topics(const std::vector<PublishedTopic>& published) {
  std::set<std::string> names;
  for (const PublishedTopic& topic : published) {
    if (topic.type == kCloud && !is_output(topic.name)) names.insert(topic.name);
  }
  return {names.begin(), names.end()};
}

std::string why_no_cloud(const std::string& points, const std::vector<PublishedTopic>& published) {
  std::string other;  // type of the messages on the topic
  for (const PublishedTopic& topic : published) {
    if (without_slash(topic.name) != without_slash(points)) continue;
    if (topic.type == kCloud)
      return fmt::format(
          "topic {} is published, and no cloud has arrived yet; where this lasts, raise net.core.rmem_max "
          "(docs/ros2.md)",
          points);
    other = topic.type;
  }
  if (!other.empty())
    return fmt::format("topic {} carries {}, not {}: {}", points, other, kCloud, remedy_for(other));
  const std::vector<std::string> clouds = cloud_topics(published);
  return fmt::format("nobody publishes on topic {}; topics of clouds: {}", points,
                     clouds.empty() ? "none (see the driver, and ROS_DOMAIN_ID)"
                                    : fmt::format("{}", fmt::join(clouds, ", ")));
}

}  // namespace mapless
