#include <algorithm>
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_robot.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

using test::add_poses;
using test::kScans;
using test::kTurnMs;
using test::Robot;
using test::with_own_odometry;
using test::with_poses;

constexpr double kVoxel_m = 0.25;

LiveOptions with_map(LiveOptions options) {
  options.static_map_file = "map.pcd";
  options.live.static_map_voxel_m = kVoxel_m;
  return options;
}

// What is written, in place of a file.
struct Written {
  explicit Written(const StaticMap& map) {
    answer = map.save([this](const std::string& name, const ExportCloud& cloud) {
      file = name;
      points = cloud.points;
      const auto& counts = cloud.columns.front().values;
      measured = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
    });
  }

  StaticMap::Answer answer;
  std::string file;
  std::vector<Eigen::Vector3d> points;
  std::size_t measured = 0;  // that the points are the means of
};

std::size_t count(const std::vector<LiveOutput>& outputs, PointMotion motion) {
  std::size_t points = 0;
  for (const LiveOutput& output : outputs) {
    const auto motions = point_motions(output);
    points += static_cast<std::size_t>(std::count(motions.begin(), motions.end(), motion));
  }
  return points;
}

const std::vector<LiveOutput>& labelled() {
  static const std::vector<LiveOutput> outputs = [] {
    Robot robot(with_poses());
    add_poses(robot, 1000, 1000 + kTurnMs * kScans);
    robot.drive(0, 12);
    return robot.outputs();
  }();
  return outputs;
}

void add_all(StaticMap& map, const std::vector<LiveOutput>& outputs) {
  for (const LiveOutput& output : outputs) map.add(output);
}

TEST(StaticMap, NothingIsKeptWithoutAFile) {
  StaticMap map(with_poses());
  add_all(map, labelled());
  const Written written(map);
  EXPECT_FALSE(written.answer.success);
  EXPECT_THAT(written.answer.message, HasSubstr("set static_map_file"));
}

TEST(StaticMap, BeforeTheFirstLabelsThereIsNothingToWrite) {
  const StaticMap map(with_map(with_poses()));
  const Written written(map);
  EXPECT_FALSE(written.answer.success);
  EXPECT_THAT(written.answer.message, HasSubstr("no cloud with labels"));
  EXPECT_EQ(written.file, "");
}

// The mean of the points of a voxel is within its diagonal of each of them. The world is that of the poses;
// the lidar moves by 0.8 m a turn, within which each point has its own pose.
TEST(StaticMap, HasTheStillPointsOfAllCloudsInTheWorld) {
  StaticMap map(with_map(with_poses()));
  add_all(map, labelled());
  const Written written(map);
  ASSERT_TRUE(written.answer.success) << written.answer.message;
  EXPECT_EQ(written.file, std::filesystem::absolute("map.pcd"));
  EXPECT_THAT(written.answer.message, HasSubstr(written.file + ": "));
  EXPECT_EQ(written.measured, count(labelled(), PointMotion::still));
  EXPECT_GT(count(labelled(), PointMotion::moving), 100U);
  EXPECT_THAT(written.answer.message, AllOf(HasSubstr(std::to_string(written.points.size()) + " points"),
                                            HasSubstr("of 11 clouds"), Not(HasSubstr("anew"))));
  // Sides of houses that face the street or the sensor: y = 10 m and -10 m beside it, x = 40 m ahead. Nothing
  // else is near them.
  std::size_t beside = 0, ahead = 0;
  for (const Eigen::Vector3d& p : written.points) {
    if (p.z() < 0) continue;
    if (p.x() > -10 && p.x() < 20 && std::abs(p.y()) > 9.5) {
      EXPECT_NEAR(std::abs(p.y()), 10, 0.1);
      ++beside;
    }
    if (p.x() > 35 && p.x() < 45 && p.y() > 11.2 && p.y() < 14.8) {
      EXPECT_NEAR(p.x(), 40, 0.1);
      ++ahead;
    }
  }
  EXPECT_GT(beside, 100U);
  EXPECT_GT(ahead, 10U);
}

// Own odometry does not know how far it went while there were no clouds; other poses do.
TEST(StaticMap, BeginsAnewWithTheOwnOdometry) {
  for (const bool own : {true, false}) {
    SCOPED_TRACE(own);
    Robot robot(own ? with_own_odometry() : with_poses());
    if (!own) add_poses(robot, 1000, 1000 + kTurnMs * kScans);
    robot.drive(0, 8);
    robot.pass_ms(12 * kTurnMs);
    robot.drive(20, 24);
    std::vector<LiveOutput> outputs = robot.outputs();
    for (LiveOutput& output : robot.live().reset()) outputs.push_back(std::move(output));
    ASSERT_EQ(outputs.size(), 12U);
    StaticMap map(with_map(own ? with_own_odometry() : with_poses()));
    add_all(map, outputs);
    const Written written(map);
    if (own) {
      EXPECT_THAT(written.answer.message, AllOf(HasSubstr("of 4 clouds"), HasSubstr("began anew 1 times")));
      EXPECT_EQ(written.measured, count({outputs.begin() + 8, outputs.end()}, PointMotion::still));
    } else {
      EXPECT_THAT(written.answer.message, AllOf(HasSubstr("of 12 clouds"), Not(HasSubstr("anew"))));
    }
  }
}

TEST(StaticMap, LeavesOutACloudWhoseMotionIsLost) {
  LiveOutput lost = labelled().back();
  lost.labelled.detection.motion_known = false;
  StaticMap map(with_map(with_poses()));
  map.add(lost);
  EXPECT_FALSE(Written(map).answer.success);
}

TEST(StaticMap, ForgetsWhatIsCleared) {
  StaticMap map(with_map(with_poses()));
  add_all(map, labelled());
  map.clear();
  EXPECT_FALSE(Written(map).answer.success);
  map.add(labelled().back());
  const Written written(map);
  EXPECT_EQ(written.measured, count({labelled().back()}, PointMotion::still));
  EXPECT_THAT(written.answer.message, AllOf(HasSubstr("of 1 clouds"), Not(HasSubstr("anew"))));
}

// The place of the base frame moves the world: 2 m below the lidar, which is 1.73 m above the ground.
TEST(StaticMap, WaitsForTheBaseFrame) {
  LiveOptions options = with_map(with_own_odometry());
  options.base_frame = "base_link";
  Robot robot(options);
  robot.drive(0, 8);
  StaticMap map(options);
  add_all(map, robot.outputs());
  EXPECT_FALSE(Written(map).answer.success);
  robot.live().add_transform("base_link", "lidar", Time(), SE3(Eigen::Matrix3d::Identity(), {0, 0, 2}), true);
  robot.drive(8, 12);
  add_all(map, {robot.outputs().begin() + 8, robot.outputs().end()});
  const Written written(map);
  ASSERT_TRUE(written.answer.success) << written.answer.message;
  const auto height = [](const auto& a, const auto& b) { return a.z() < b.z(); };
  EXPECT_NEAR(std::min_element(written.points.begin(), written.points.end(), height)->z(), 0.27, 0.15);
}

TEST(StaticMap, AFullMapSaysWhatItLeavesOut) {
  LiveOptions options = with_map(with_poses());
  options.live.static_map_max_voxels = 1000;
  StaticMap map(options);
  add_all(map, labelled());
  const Written written(map);
  EXPECT_EQ(written.points.size(), 1000U);
  const std::size_t left_out = count(labelled(), PointMotion::still) - written.measured;
  EXPECT_GT(left_out, 0U);
  EXPECT_THAT(written.answer.message, AllOf(HasSubstr(std::to_string(left_out) + " points are left out"),
                                            HasSubstr("static_map_max_voxels")));
}

TEST(StaticMap, AFileThatCannotBeWrittenIsTheAnswerAndTheMapIsKept) {
  StaticMap map(with_map(with_poses()));
  add_all(map, labelled());
  const StaticMap::Answer answer = map.save([](const std::string& file, const ExportCloud&) {
    throw OutputError({file, "", "", "cannot be written: No space left on device", "check the disk"});
  });
  EXPECT_FALSE(answer.success);
  EXPECT_THAT(answer.message,
              EndsWith("map.pcd: cannot be written: No space left on device; check the disk"));
  EXPECT_TRUE(Written(map).answer.success);
}

TEST(StaticMapThreads, CloudsAreAddedWhileTheFileIsWritten) {
  StaticMap map(with_map(with_poses()));
  map.add(labelled().front());
  std::promise<void> disk;
  std::promise<StaticMap::Answer> answer;
  std::size_t points = 0;
  map.save_aside(
      [&](const std::string&, const ExportCloud& cloud) {
        disk.get_future().wait_for(std::chrono::seconds(10));  // in vain only where both are written
        points = cloud.points.size();
      },
      [&](const StaticMap::Answer& one) { answer.set_value(one); });
  map.add(labelled().back());
  bool refused = false;
  map.save_aside([](const std::string&, const ExportCloud&) { FAIL() << "two at once"; },
                 [&](const StaticMap::Answer& one) {
                   refused = !one.success && one.message.find("being written") != std::string::npos;
                 });
  EXPECT_TRUE(refused);
  disk.set_value();
  const StaticMap::Answer written = answer.get_future().get();
  EXPECT_TRUE(written.success);
  EXPECT_THAT(written.message, HasSubstr(std::to_string(points) + " points"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
