#include <cmath>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::ToyScene;
using ::testing::Contains;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr int kFrames = 9;
constexpr int kColumns = 360;

/// A drive through a room that speeds up, slows down and turns back and forth, so that one turn of the sensor
/// is not like the next: 2.5 +- 1.5 m/s, up to 1 rad/s.
class UnsteadyDrive final : public Trajectory {
 public:
  [[nodiscard]] Time begin() const override { return Time::from_seconds(-1); }
  [[nodiscard]] Time end() const override { return Time::from_seconds(10); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    const double s = t.seconds(), w = 5;
    const SE3 T_0v(rotation_z(0.3 + 0.2 * std::sin(w * s)),
                   {-3 + 2.5 * s + 1.5 / w * std::sin(w * s), 0.3 * s, 0.1 * s});
    return {T_0v.inverse(), Vector6d::Zero()};  // the velocity is not needed
  }
};

using PosesOf = std::function<void(const Trajectory&, MdlidarFrame&)>;

void start_and_end(const Trajectory& drive, MdlidarFrame& frame) {
  frame.pose_p = drive.at(frame.start).T_v0.inverse();
  frame.pose = drive.at(frame.end).T_v0.inverse();
}

/// Poses at the start of the frame, and `before` that.
PosesOf before_and_start(Duration before) {
  return [before](const Trajectory& drive, MdlidarFrame& frame) {
    frame.pose_p = drive.at(frame.start - before).T_v0.inverse();
    frame.pose = drive.at(frame.start).T_v0.inverse();
  };
}

PosesOf inverse_of(const PosesOf& poses) {
  return [poses](const Trajectory& drive, MdlidarFrame& frame) {
    poses(drive, frame);
    frame.pose_p = frame.pose_p.inverse();
    frame.pose = frame.pose.inverse();
  };
}

/// Eight lasers, all from the origin of the sensor.
std::shared_ptr<const LidarModel> small_sensor() {
  LidarModel model;
  model.name = "eight lasers";
  model.columns = kColumns;
  model.rotation_rate_hz = 10;
  model.direction = SpinDirection::clockwise;
  model.max_range_m = 120;
  for (int l = 0; l < 8; ++l) {
    Laser laser;
    laser.elevation_rad = 0.05 * (l - 3.5);
    model.lasers.push_back(laser);
  }
  return std::make_shared<const LidarModel>(model);
}

ToyScene room(const std::shared_ptr<const Trajectory>& drive) {
  ToyScene scene = test::toy_room("VLP-16", drive);
  scene.model = small_sensor();
  scene.empty_code = ReturnCode::faulty;
  return scene;
}

void write_recording(const fs::path& folder, const ToyScene& scene, const PosesOf& poses) {
  std::vector<MdlidarLaser> lasers;
  for (const Laser& laser : scene.model->lasers) lasers.push_back({0, 0, 0, laser.elevation_rad});
  MdlidarWriter writer(folder, lasers, kColumns, Duration::from_seconds(0.1));
  for (int k = 0; k < kFrames; ++k) {
    const test::ToyScan scan = cast_scan(scene, k);
    MdlidarFrame frame;
    frame.start = scan.scan->start;
    frame.end = scan.scan->column_time(kColumns - 1);
    poses(*scene.trajectory, frame);
    for (const LidarRecord& record : scan.records) {
      MdlidarPoint point;
      if (record.code == ReturnCode::hit) point.range_m = record.position_v.norm();
      point.rotation_deg = static_cast<float>(record.column);  // 360 columns
      frame.points.push_back(point);
    }
    writer.write(frame);
  }
  writer.finish();
}

// The trajectory of the recording moves the sensor as the drive did.
void expect_motion(const Dataset& dataset, const Trajectory& drive) {
  const auto read = dataset.trajectory();
  const Time t_1 = dataset.scan_start(1);
  for (std::size_t k = 1; k < dataset.size(); ++k) {
    const Time t = dataset.scan_start(k);
    const SE3 truth = drive.at(t).T_v0 * drive.at(t_1).T_v0.inverse();
    const SE3 motion = read->at(t).T_v0 * read->at(t_1).T_v0.inverse();
    EXPECT_LT((motion * truth.inverse()).log().norm(), 0.01) << "scan " << k;
  }
}

class PoseReading : public ::testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] fs::path town() const { return folder_ / "town_1"; }
  [[nodiscard]] static PosesOf poses() {
    if (GetParam() == "start and end") return start_and_end;
    return before_and_start(Duration::from_seconds(GetParam() == "frame before" ? 0.1 : 0.001));
  }
  TemporaryFolder folder_;
};

TEST_P(PoseReading, IsFoundFromTheScans) {
  const auto drive = std::make_shared<const UnsteadyDrive>();
  for (const bool inverse : {false, true}) {
    SCOPED_TRACE(inverse);
    fs::remove_all(town());
    write_recording(town(), room(drive), inverse ? inverse_of(poses()) : poses());
    expect_motion(*open_dataset(town()), *drive);
  }
}

// A frame is 0.1 s; an instant may also be a step of a simulation.
INSTANTIATE_TEST_SUITE_P(Mdlidar, PoseReading,
                         ::testing::Values("start and end", "frame before", "step before"));

class MdlidarPoses : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path town() const { return folder_ / "town_1"; }
  TemporaryFolder folder_;
};

TEST_F(MdlidarPoses, AreFoundAmongMovingObjects) {
  const auto drive = std::make_shared<const UnsteadyDrive>();
  ToyScene scene = room(drive);
  // Two walls that recede ahead and behind, and cross the room: the sensor sees them move at any reading.
  for (const double x : {4.0, -5.0}) {
    test::ToyBody wall = test::toy_box({x, 1.5, 0}, {0.1, 1.5, 1});
    wall.velocity_0 = {3, -1.5, 0};
    scene.world.push_back(wall);
  }
  write_recording(town(), scene, before_and_start(Duration::from_seconds(0.1)));
  expect_motion(*open_dataset(town()), *drive);
}

TEST_F(MdlidarPoses, AreReadAsTheUserSays) {
  const auto drive = std::make_shared<const UnsteadyDrive>();
  write_recording(town(), room(drive), start_and_end);
  DatasetOptions options;
  options.pose_direction = PoseDirection::sensor_from_world;
  options.pose_instant = FramePoseInstant::start;
  const auto dataset = open_dataset(town(), options);
  const Time t = dataset->scan_start(3);
  const SE3 T_0v_end = drive->at(t + Duration::from_seconds(0.1 * (kColumns - 1) / kColumns)).T_v0.inverse();
  EXPECT_LT((dataset->trajectory()->at(t).T_v0 * T_0v_end.inverse()).log().norm(), 1e-4);
}

TEST_F(MdlidarPoses, OfAStandingSensorMeanTheSameEitherWay) {
  write_recording(town(), room(std::make_shared<StationaryTrajectory>()), start_and_end);
  const auto dataset = open_dataset(town());
  EXPECT_THAT(dataset->notes(), Contains(HasSubstr("direction of the poses does not matter")));
  EXPECT_THAT(dataset->notes(), Contains(HasSubstr("instant of the poses does not matter")));
  EXPECT_NE(dataset->trajectory(), nullptr);
}

TEST_F(MdlidarPoses, AreRefusedWhereStaticPointsMoveUnderEveryReading) {
  // In feet, so that the sensor moves three times too far.
  const auto in_feet = [](const Trajectory& drive, MdlidarFrame& frame) {
    start_and_end(drive, frame);
    frame.pose_p = SE3(frame.pose_p.rotation(), frame.pose_p.translation() / 0.3048);
    frame.pose = SE3(frame.pose.rotation(), frame.pose.translation() / 0.3048);
  };
  write_recording(town(), room(std::make_shared<const UnsteadyDrive>()), in_feet);
  const auto dataset = open_dataset(town());  // whose scans can be used with other poses
  EXPECT_GT(dataset->read(0).returns.size(), 1000U);
  try {
    (void)dataset->trajectory();
    ADD_FAILURE() << ::testing::PrintToString(dataset->notes());
  } catch (const InputError& error) {
    EXPECT_EQ(error.detail().where, (town() / "frame").string());
    EXPECT_EQ(error.detail().field, "state");
    EXPECT_THAT(error.detail().remedy, HasSubstr("--own-pose-direction"));
  }
  DatasetOptions as_given;
  as_given.pose_direction = PoseDirection::world_from_sensor;
  as_given.pose_instant = FramePoseInstant::end;
  EXPECT_NE(open_dataset(town(), as_given)->trajectory(), nullptr);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
