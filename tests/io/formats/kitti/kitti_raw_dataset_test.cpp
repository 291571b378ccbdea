#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/bare_cloud.hpp"
#include "support/paths.hpp"
#include "support/recording_error.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::Cloud;
using test::TemporaryFolder;
using test::write_kitti_cloud;
using test::write_text;
using ::testing::Contains;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

// A drive with frames 0, 1 and 3 of a 16-laser sensor, scans of 100 ms from 23:59:59.85 on.
class KittiRaw : public ::testing::Test {
 protected:
  void SetUp() override {
    const LidarModel model = test::make_bare_cloud_model(16, 500);
    cloud_ = test::make_bare_cloud(model, 0);
    for (const char* name : {"0000000000.bin", "0000000001.bin", "0000000003.bin"}) {
      write_kitti_cloud(points() / "data" / name, cloud_);
    }
    write_text(points() / "timestamps_start.txt",
               "2011-09-26 23:59:59.850000001\n2011-09-26 23:59:59.950000002\n2011-09-27 00:00:00.050000003\n"
               "2011-09-27 00:00:00.150000004\n");
    write_text(points() / "timestamps_end.txt",
               "2011-09-26 23:59:59.950000001\n2011-09-27 00:00:00.050000002\n2011-09-27 00:00:00.150000003\n"
               "2011-09-27 00:00:00.250000004\n");
  }

  [[nodiscard]] fs::path drive() const { return folder_ / "2011_09_26_drive_0001_sync"; }
  [[nodiscard]] fs::path points() const { return drive() / "velodyne_points"; }

  [[nodiscard]] ErrorDetail error() const { return test::recording_error(drive()); }

  TemporaryFolder folder_;
  Cloud cloud_;
};

TEST_F(KittiRaw, OpensDrivePointsAndDateFolder) {
  for (const fs::path& path : {drive(), points(), folder_.path(), points() / ""}) {
    SCOPED_TRACE(path);
    const auto dataset = open_dataset(path);
    EXPECT_EQ(dataset->format(), "kitti-raw");
    EXPECT_EQ(dataset->size(), 3U);
  }
}

TEST_F(KittiRaw, ScansAreSortedByNumberAcrossMidnight) {
  const auto dataset = open_dataset(drive());
  EXPECT_EQ((dataset->scan_start(1) - dataset->scan_start(0)).nanoseconds(), 100000001);
  EXPECT_EQ((dataset->scan_start(2) - dataset->scan_start(0)).nanoseconds(), 300000003);
  EXPECT_EQ((dataset->scan_end(2) - dataset->scan_start(2)).nanoseconds(), 100000000);
  EXPECT_EQ(dataset->scan_file(2).filename(), "0000000003.bin");
  EXPECT_THAT(dataset->notes(), Contains("frames missing: 2"));
}

TEST_F(KittiRaw, EveryPointIsAReturnWithItsRow) {
  const LidarScan scan = open_dataset(drive())->read(0);
  EXPECT_EQ(scan.input_size, cloud_.size());
  ASSERT_EQ(scan.returns.size(), cloud_.size());
  EXPECT_EQ(scan.rows(), 16);
  EXPECT_EQ(scan.columns, 500);
  EXPECT_EQ(scan.time_source, Provenance::recovered_from_angle);
  EXPECT_EQ(scan.ring_source, Provenance::recovered_from_order);
  EXPECT_FALSE(scan.compensated_to.has_value());
  for (const LidarReturn& r : scan.returns) {
    EXPECT_EQ(r.laser, 15 - static_cast<int>(r.input_index) / 500);
    EXPECT_EQ(r.position_v, cloud_[r.input_index]);
  }
}

TEST_F(KittiRaw, ReadsLabelsOfTheDriveOrOfAnotherFolder) {
  EXPECT_FALSE(open_dataset(drive())->read_labels(0).has_value());
  std::vector<std::uint32_t> labels(cloud_.size(), kLabelStatic);
  labels[7] = kLabelDynamic | (5U << 16);
  fs::create_directories(drive() / "labels");
  write_label_file(drive() / "labels" / "000003.label", labels);
  const auto own = open_dataset(drive());
  EXPECT_FALSE(own->read_labels(0).has_value());
  EXPECT_EQ(own->read_labels(2).value(), labels);

  labels[8] = kLabelDynamic;
  fs::create_directories(folder_ / "truth");
  write_label_file(folder_ / "truth" / "000000.label", labels);
  DatasetOptions options;
  options.labels = folder_ / "truth";
  const auto other = open_dataset(drive(), options);
  EXPECT_EQ(other->read_labels(0).value(), labels);
  EXPECT_FALSE(other->read_labels(2).has_value());
  options.labels = folder_ / "none";
  EXPECT_THROW((void)open_dataset(drive(), options), InputError);
}

TEST_F(KittiRaw, LabelsOfAnotherLengthAreRefused) {
  fs::create_directories(drive() / "labels");
  write_label_file(drive() / "labels" / "000000.label", {9, 9});
  EXPECT_THROW((void)open_dataset(drive())->read_labels(0), InputError);
}

TEST_F(KittiRaw, UsesANamedSensor) {
  DatasetOptions options;
  options.sensor = "VLP-16";
  const auto dataset = open_dataset(drive(), options);
  EXPECT_FALSE(dataset->model_estimate().has_value());
  EXPECT_EQ(dataset->model()->name, "VLP-16");
  EXPECT_NEAR(dataset->model()->rotation_rate_hz, 10, 1e-6);
  EXPECT_NEAR(dataset->model()->hub_angle(0), M_PI, 1e-12);
  EXPECT_EQ(dataset->read(0).returns.front().laser, 0);
}

TEST_F(KittiRaw, RefusesATruncatedScan) {
  fs::resize_file(points() / "data" / "0000000001.bin", 16 * 100 + 5);
  const ErrorDetail detail = error();
  EXPECT_EQ(detail.where, (points() / "data" / "0000000001.bin").string());
  EXPECT_THAT(detail.value, HasSubstr("1605"));
}

TEST_F(KittiRaw, RefusesAnEmptyScanFile) {
  fs::resize_file(points() / "data" / "0000000003.bin", 0);
  EXPECT_EQ(error().where, (points() / "data" / "0000000003.bin").string());
}

TEST_F(KittiRaw, RefusesMissingTimestamps) {
  fs::remove(points() / "timestamps_end.txt");
  EXPECT_EQ(error().where, (points() / "timestamps_end.txt").string());
}

TEST_F(KittiRaw, RefusesFewerTimestampsThanScans) {
  write_text(points() / "timestamps_start.txt", "2011-09-26 23:59:59.85\n2011-09-26 23:59:59.95\n");
  const ErrorDetail detail = error();
  EXPECT_EQ(detail.value, "2");
  EXPECT_THAT(detail.problem, HasSubstr("3 .bin files"));
  EXPECT_THAT(detail.problem, HasSubstr("4 lines"));
}

TEST_F(KittiRaw, RefusesInvalidAndDecreasingTimestamps) {
  write_text(points() / "timestamps_start.txt",
             "2011-09-26 23:59:59.85\nyesterday\n\n2011-09-27 00:00:00.15\n");
  EXPECT_EQ(error().where, (points() / "timestamps_start.txt:2").string());
  write_text(points() / "timestamps_start.txt",
             "2011-09-26 23:59:59.85\n2011-09-27 00:00:01\n\n2011-09-27 00:00:00.15\n");
  EXPECT_EQ(error().where, (points() / "timestamps_end.txt:2").string());
}

TEST_F(KittiRaw, NotFinitePointsAreFaultyReturns) {
  cloud_[10].x() = std::numeric_limits<float>::quiet_NaN();
  cloud_[11].z() = std::numeric_limits<float>::infinity();
  write_kitti_cloud(points() / "data" / "0000000001.bin", cloud_);
  const LidarScan scan = open_dataset(drive())->read(1);
  EXPECT_EQ(scan.input_size, cloud_.size());
  EXPECT_EQ(scan.returns.size(), cloud_.size() - 2);
}

TEST_F(KittiRaw, RefusesADateFolderWithTwoDrives) {
  write_kitti_cloud(folder_ / "2011_09_26_drive_0002_sync" / "velodyne_points" / "data" / "0.bin", cloud_);
  try {
    (void)open_dataset(folder_.path());
    FAIL() << "accepted";
  } catch (const InputError& e) {
    EXPECT_EQ(e.detail().field, "drives");
    EXPECT_EQ(e.detail().value, "2");
  }
}

// The recording of 50 scans with the README's facts: 64 rings, times to the nanosecond.
TEST(KittiRawShared, EstimatesTheSensorOfARealDrive) {
  const fs::path date = test::shared_data("kitti_raw/2011_09_26");
  MAPLESS_SKIP_WITHOUT(date);
  DatasetOptions options;
  options.labels = date / "2011_09_26_drive_0005_sync" / "labels_derived";
  const auto dataset = open_dataset(date, options);
  ASSERT_EQ(dataset->size(), 50U);
  EXPECT_EQ(dataset->scan_start(0).nanoseconds(), 1317042272283701593);
  EXPECT_EQ(dataset->trajectory(), nullptr);
  const ModelEstimate estimate = dataset->model_estimate().value();
  EXPECT_LT(estimate.elevation_residual_m, 0.001);
  EXPECT_EQ(estimate.encoder_steps, 4000);
  EXPECT_EQ(estimate.azimuths_known, 64);
  EXPECT_EQ(estimate.lasers_borrowed, 0);
  const LidarModel& model = *dataset->model();
  ASSERT_EQ(model.lasers.size(), 64U);
  EXPECT_NEAR(model.lasers.front().elevation_rad * 180 / M_PI, -24.999, 0.01);
  EXPECT_NEAR(model.lasers.back().elevation_rad * 180 / M_PI, 1.937, 0.01);
  // As the calibration of every HDL-64E: origins 2.6 cm to alternating sides, about 8 cm between the blocks.
  for (std::size_t i = 0; i < 64; ++i) {
    const Eigen::Vector3d& origin = model.lasers[i].origin_h_m;
    EXPECT_NEAR(origin.head<2>().norm(), 0.026, 0.001);
    EXPECT_NEAR(origin.z(), i < 32 ? 0.121 : 0.203, 0.007);
  }
  // Every firing of every laser has a cell of its own.
  for (const std::size_t k : {std::size_t{0}, std::size_t{42}}) {
    const LidarScan scan = dataset->read(k);
    std::set<std::pair<int, int>> cells;
    for (const LidarReturn& r : scan.returns) cells.emplace(r.laser, r.column);
    EXPECT_EQ(cells.size(), scan.input_size);
    EXPECT_EQ(dataset->read_labels(k).value().size(), scan.input_size);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
