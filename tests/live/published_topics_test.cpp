#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/live/live_options.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kCloud = "sensor_msgs/msg/PointCloud2";

TEST(CloudTopics, AreSortedAndNamedOnce) {
  EXPECT_THAT(
      cloud_topics({{"roof", kCloud}, {"imu", "sensor_msgs/msg/Imu"}, {"bumper", kCloud}, {"roof", kCloud}}),
      ElementsAre("bumper", "roof"));
  EXPECT_THAT(cloud_topics({}), ElementsAre());
  EXPECT_THAT(cloud_topics({{"roof/points_labelled", kCloud}, {"points_static", kCloud}, {"points", kCloud}}),
              ElementsAre("points"));
}

TEST(WhyNoCloud, NamesTheTopicsOfClouds) {
  EXPECT_THAT(
      why_no_cloud("points", {{"/roof", kCloud}, {"/imu", "sensor_msgs/msg/Imu"}}),
      AllOf(HasSubstr("nobody publishes on topic points"), HasSubstr("/roof"), Not(HasSubstr("/imu"))));
  EXPECT_THAT(why_no_cloud("points", {}), AllOf(HasSubstr("none"), HasSubstr("ROS_DOMAIN_ID")));
}

// As with ROS 2, whose names begin with a slash, and with DDS, whose do not.
TEST(WhyNoCloud, NamesTheTypeThatTheTopicCarries) {
  for (const char* name : {"points", "/points"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(why_no_cloud("/points", {{name, "sensor_msgs/msg/LaserScan"}, {"/roof", kCloud}}),
                AllOf(HasSubstr("carries sensor_msgs/msg/LaserScan"), HasSubstr(kCloud)));
  }
  EXPECT_THAT(why_no_cloud("points", {{"points", "livox_ros_driver2/msg/CustomMsg"}}),
              HasSubstr("not supported"));  // its PointCloud2, too, is refused (driver_fields.cpp)
  EXPECT_THAT(why_no_cloud("points", {{"points", "velodyne_msgs/msg/VelodyneScan"}}), HasSubstr("packets"));
  EXPECT_THAT(why_no_cloud("points", {{"points", "ouster_sensor_msgs/msg/PacketMsg"}}), HasSubstr("packets"));
}

// A driver that publishes both on one name is no reason.
TEST(WhyNoCloud, CloudsThatDoNotArriveAreLostOnTheirWay) {
  for (const bool cloud_first : {true, false}) {
    std::vector<PublishedTopic> published = {{"points", kCloud}, {"points", "sensor_msgs/msg/Imu"}};
    if (!cloud_first) std::swap(published[0], published[1]);
    EXPECT_THAT(why_no_cloud("points", published), HasSubstr("rmem_max"));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
