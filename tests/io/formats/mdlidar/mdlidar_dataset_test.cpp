#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include "support/bare_cloud.hpp"
#include "support/recording_error.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::write_text;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr int kLasers = 4;
constexpr int kColumns = 90;
constexpr std::int64_t kTurn_ns = 99'000'000;

// Not by elevation, with offsets of every kind.
const std::vector<MdlidarLaser> kCalibration = {{0.026, 0.2, -0.08, 0.03},
                                                {-0.026, 0.12, 0.1, -0.3},
                                                {0.026, 0.19, 0.02, -0.02},
                                                {-0.026, 0.11, 0.0, -0.2}};

SE3 T_0v_at(double t_s) {
  Vector6d velocity;
  velocity << 8, 0.5, 0, 0.1, 0, 0.4;
  return SE3::exp(velocity * t_s);
}

MdlidarFrame make_frame(int k) {
  MdlidarFrame frame;
  frame.start = Time::from_nanoseconds(1'000'000'000 + k * kTurn_ns);
  frame.end = frame.start + Duration::from_nanoseconds(kTurn_ns);
  frame.pose_p = T_0v_at(k * 0.099);
  frame.pose = T_0v_at((k + 1) * 0.099);
  std::mt19937 random(static_cast<unsigned>(k));
  for (int l = 0; l < kLasers; ++l) {
    for (int c = 0; c < kColumns; ++c) {
      MdlidarPoint point;
      if (random() % 4 != 0) point.range_m = 2 + static_cast<float>(random() % 50000) / 1000;
      point.rotation_deg = static_cast<float>(180 + 4 * c);
      if (point.rotation_deg >= 360) point.rotation_deg -= 360;
      point.object_id = static_cast<int>(random() % 3);
      point.dynamic = point.object_id == 2;
      frame.points.push_back(point);
    }
  }
  return frame;
}

class Mdlidar : public ::testing::Test {
 protected:
  void SetUp() override {
    MdlidarWriter writer(town(), kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns));
    for (int k = 0; k < 11; ++k) writer.write(make_frame(k));
    writer.finish();
  }
  [[nodiscard]] fs::path town() const { return folder_ / "town_1"; }

  [[nodiscard]] ErrorDetail error() const { return test::recording_error(town()); }

  TemporaryFolder folder_;
};

TEST_F(Mdlidar, ReadsBackTheWrittenRays) {
  const auto dataset = open_dataset(town());
  EXPECT_EQ(dataset->format(), "mdlidar");
  ASSERT_EQ(dataset->size(), 11U);
  EXPECT_EQ(dataset->scan_file(10).filename(), "data_10");
  // Rows by elevation: -0.3, -0.2, -0.02, 0.03 rad are rows of the calibration 1, 3, 2, 0.
  const std::vector<int> row_of = {3, 0, 2, 1};
  const MdlidarFrame frame = make_frame(10);
  const LidarScan scan = dataset->read(10);
  EXPECT_EQ(scan.start.nanoseconds(), frame.start.nanoseconds());
  EXPECT_EQ(scan.input_size, frame.points.size());
  EXPECT_EQ(scan.columns, kColumns);
  std::size_t hits = 0;
  for (const MdlidarPoint& p : frame.points) hits += p.range_m > 0 ? 1 : 0;
  ASSERT_EQ(scan.returns.size(), hits);
  for (const LidarReturn& r : scan.returns) {
    const auto laser = static_cast<std::size_t>(r.input_index / kColumns);
    const int column = static_cast<int>(r.input_index) % kColumns;
    const MdlidarPoint& p = frame.points[r.input_index];
    ASSERT_EQ(r.laser, row_of[laser]);
    ASSERT_EQ(r.column, column);
    EXPECT_NEAR(r.range_m, p.range_m, 1e-4);
    EXPECT_NEAR(r.time_ns, static_cast<double>(column) / (kColumns - 1) * kTurn_ns, 1);
    // method.md section 4, by hand.
    const MdlidarLaser& l = kCalibration[laser];
    const double a = p.rotation_deg * std::numbers::pi / 180 - l.rot_correction_rad;
    const double phi = l.vert_correction_rad;
    const double xy = p.range_m * std::cos(phi) - l.vert_offset_m * std::sin(phi);
    const Eigen::Vector3d expected(xy * std::cos(a) + l.horiz_offset_m * std::sin(a),
                                   -xy * std::sin(a) + l.horiz_offset_m * std::cos(a),
                                   p.range_m * std::sin(phi) + l.vert_offset_m * std::cos(phi));
    EXPECT_LT((r.position_v.cast<double>() - expected).norm(), 1e-4);
    EXPECT_LT((scan.model->point_v(r.laser, r.column, p.range_m) - expected).norm(), 1e-4);
  }
}

TEST_F(Mdlidar, AMissingReturnIsFaulty) {
  const LidarScan scan = open_dataset(town())->read(0);
  const std::vector<int> channel_of_row = {1, 3, 2, 0};
  const MdlidarFrame frame = make_frame(0);
  for (int row = 0; row < kLasers; ++row) {
    for (int c = 0; c < kColumns; ++c) {
      const auto i = static_cast<std::size_t>(channel_of_row[static_cast<std::size_t>(row)] * kColumns + c);
      EXPECT_EQ(code_of_cell(scan.cell(row, c)),
                frame.points[i].range_m > 0 ? ReturnCode::hit : ReturnCode::faulty);
    }
  }
}

TEST_F(Mdlidar, ReadsALabelForEveryPoint) {
  const MdlidarFrame frame = make_frame(3);
  const auto labels = open_dataset(town())->read_labels(3).value();
  ASSERT_EQ(labels.size(), frame.points.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const MdlidarPoint& p = frame.points[i];
    const std::uint32_t id = static_cast<std::uint32_t>(p.object_id) << 16;
    EXPECT_EQ(labels[i], p.range_m < 0 ? 0U : (p.dynamic ? 251U : 9U) | id);
  }
}

TEST_F(Mdlidar, ReadsPosesOfEitherDirection) {
  const double times[] = {0.0, 0.03, 0.099, 0.5, 1.08};
  const auto forward = open_dataset(town());
  DatasetOptions options;
  options.pose_direction = PoseDirection::sensor_from_world;
  const auto backward = open_dataset(town(), options);
  for (const double t : times) {
    SCOPED_TRACE(t);
    const Time time = Time::from_seconds(1 + t);
    EXPECT_LT((forward->trajectory()->at(time).T_v0 * T_0v_at(t)).log().norm(), 1e-4);
  }
  EXPECT_LT(
      (backward->trajectory()->at(Time::from_seconds(1.099)).T_v0 * T_0v_at(0.099).inverse()).log().norm(),
      1e-4);
}

TEST_F(Mdlidar, FindsTheCalibrationOneFolderUp) {
  fs::rename(town() / "vel_64_calib.csv", folder_ / "vel_64_calib.csv");
  EXPECT_EQ(open_dataset(town())->size(), 11U);
  fs::remove(folder_ / "vel_64_calib.csv");
  EXPECT_THAT(error().where, HasSubstr("vel_64_calib.csv"));
}

TEST_F(Mdlidar, RefusesCorruptFrames) {
  const fs::path file = town() / "frame" / "data_4";
  const auto size = fs::file_size(file);
  for (const std::uintmax_t cut : {std::uintmax_t{0}, size / 2, size - 1}) {
    SCOPED_TRACE(cut);
    fs::resize_file(file, cut);
    EXPECT_EQ(error().where, file.string());
    fs::remove_all(town());
    SetUp();
  }
  write_text(file, "not a message at all, but a text of some length");
  EXPECT_EQ(error().where, file.string());
}

TEST_F(Mdlidar, RefusesACorruptHeaderOrCalibration) {
  const std::string calibration = "0,0,0,0\n";
  write_text(town() / "vel_64_calib.csv", calibration);
  EXPECT_EQ(error().field, "channels_count");
  write_text(town() / "vel_64_calib.csv", "0,0,0,0\n0,0,nan,0\n");
  EXPECT_EQ(error().where, (town() / "vel_64_calib.csv:2").string());
  for (const std::string row : {"0,0,1e300,0", "0,0,0,-13", "11,0,0,0"}) {
    write_text(town() / "vel_64_calib.csv", "0,0,0,0\n" + row + "\n");
    EXPECT_EQ(error().where, (town() / "vel_64_calib.csv:2").string()) << row;
  }
  write_text(town() / "vel_64_calib.csv", "0,0,0,0,0\n");
  EXPECT_EQ(error().where, (town() / "vel_64_calib.csv:1").string());
  SetUp();
  write_text(town() / "header", "\xff\xff\xff");
  EXPECT_EQ(error().where, (town() / "header").string());
}

TEST_F(Mdlidar, RefusesFramesOfAnotherNumberOfPoints) {
  const MdlidarWriter other(town() / "other", {kCalibration[0]}, kColumns,
                            Duration::from_nanoseconds(kTurn_ns));
  other.finish();
  MdlidarWriter writer(town(), kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns));
  MdlidarFrame frame = make_frame(0);
  frame.points.pop_back();
  EXPECT_THROW(writer.write(frame), InputError);
  fs::copy_file(town() / "other" / "header", town() / "header", fs::copy_options::overwrite_existing);
  EXPECT_EQ(error().field, "channels_count");
}

TEST_F(Mdlidar, RefusesPosesThatAreNotFiniteAndTimesThatDoNotIncrease) {
  MdlidarWriter writer(town(), kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns));
  MdlidarFrame frame = make_frame(0);
  frame.pose = SE3(Eigen::Matrix3d::Identity(), {std::nan(""), 0, 0});
  writer.write(frame);
  EXPECT_EQ(error().field, "state");
  frame = make_frame(1);
  frame.end = frame.start;
  MdlidarWriter again(town(), kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns));
  again.write(frame);
  EXPECT_EQ(error().field, "end_time");
}

TEST_F(Mdlidar, IsRefusedWhileItIsWritten) {
  const fs::path half = folder_ / "half";
  MdlidarWriter writer(half, kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns));
  for (int k = 0; k < 11; ++k) writer.write(make_frame(k));
  EXPECT_THROW((void)open_dataset(half), InputError);
  writer.finish();
  EXPECT_EQ(open_dataset(half)->size(), 11u);
}

TEST_F(Mdlidar, RefusesAnUnwritableFolder) {
  write_text(folder_ / "file", "");
  EXPECT_THROW(MdlidarWriter(folder_ / "file", kCalibration, kColumns, Duration::from_nanoseconds(kTurn_ns)),
               OutputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
