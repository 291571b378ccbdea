#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/pcd/pcd.hpp"
#include "io/formats/pcd/pcd_folder_dataset.hpp"
#include "support/bare_cloud.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr int kScans = 2;

enum class Stored { with_rings, in_rows, in_firing_order };

std::shared_ptr<const LidarModel> sensor(std::string_view name, SpinDirection direction) {
  LidarModel model = named_model(name);
  model.direction = direction;
  return std::make_shared<const LidarModel>(std::move(model));
}

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

// Records as cast_scan gives them: laser by laser.
void write_records(const fs::path& file, const std::vector<LidarRecord>& records, std::size_t lasers,
                   Stored stored, bool with_times) {
  PcdCloud cloud;
  cloud.height = stored == Stored::in_rows ? lasers : 1;
  cloud.width = records.size() / cloud.height;
  for (const char* name : {"x", "y", "z"}) cloud.add_field(name, 'F', 4);
  if (stored == Stored::with_rings) cloud.add_field("ring", 'U', 2);
  if (with_times) cloud.add_field("t", 'I', 4);
  const std::size_t columns = records.size() / lasers;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool by_firing = stored == Stored::in_firing_order;
    const LidarRecord& r = records[by_firing ? i % lasers * columns + i / lasers : i];
    for (const float v : r.position_v) put(cloud.bytes, v);
    if (stored == Stored::with_rings) put(cloud.bytes, static_cast<std::uint16_t>(r.laser));
    if (with_times) put(cloud.bytes, r.time_ns);
  }
  write_pcd(file, cloud);
}

struct Recording {
  test::TemporaryFolder folder;
  std::vector<test::ToyScan> scans;
};

// A room seen while driving an arc.
void record(const std::shared_ptr<const LidarModel>& model, Stored stored, bool with_times, Recording& out) {
  test::ToyScene scene = test::toy_room("VLP-16", test::drive(2, 0.3));
  scene.model = model;
  scene.range_noise_m = 0;
  std::string times;
  for (int k = 0; k < kScans; ++k) {
    out.scans.push_back(test::cast_scan(scene, k));
    write_records(out.folder / (std::to_string(k) + ".pcd"), out.scans.back().records, model->lasers.size(),
                  stored, with_times);
    times += std::to_string(0.1 * k) + "\n";
  }
  write_file_atomically(out.folder / "times.txt", times);
}

void expect_model(const LidarModel& estimated, const LidarModel& truth) {
  ASSERT_EQ(estimated.lasers.size(), truth.lasers.size());
  EXPECT_NEAR(estimated.columns, truth.columns, 1);
  EXPECT_NEAR(estimated.rotation_rate_hz, truth.rotation_rate_hz, 0.02);
  for (std::size_t i = 0; i < truth.lasers.size(); ++i) {
    SCOPED_TRACE(i);
    const Laser& laser = truth.lasers[i];
    // A beam that starts in front of the axis is the one that starts at it, lower or higher.
    const double forward = laser.origin_h_m.x() * std::cos(laser.azimuth_offset_rad) +
                           laser.origin_h_m.y() * std::sin(laser.azimuth_offset_rad);
    const double at_axis = laser.origin_h_m.z() - forward * std::tan(laser.elevation_rad);
    EXPECT_NEAR(estimated.lasers[i].elevation_rad, laser.elevation_rad, 0.02 * kDegree);
    EXPECT_NEAR(estimated.lasers[i].origin_h_m.z(), at_axis, 0.003);
  }
}

// Every point is back on its laser and on a ray through it, at its time, and so is its column.
void expect_own_rays(const LidarScan& scan, const test::ToyScan& truth, double own_time_tolerance_s) {
  std::size_t hits = 0;
  for (const LidarRecord& r : truth.records) hits += r.code == ReturnCode::hit ? 1 : 0;
  ASSERT_EQ(scan.returns.size(), hits);
  const double column_rad = 2 * kPi / scan.model->columns;
  for (const LidarReturn& r : scan.returns) {
    const LidarRecord& from = truth.records[r.input_index];
    ASSERT_EQ(r.laser, from.laser);
    const Eigen::Vector3d p = r.position_v.cast<double>();
    const Eigen::Vector3d on_ray = scan.model->point_v(r.laser, r.column, static_cast<double>(r.range_m));
    ASSERT_LT((on_ray - p).norm(), 0.6 * column_rad * p.norm() + 0.005);
    ASSERT_NEAR((scan.time_of(r) - truth.scan->start).seconds(), 1e-9 * from.time_ns, own_time_tolerance_s);
    ASSERT_NEAR((scan.column_time(r.column) - scan.time_of(r)).seconds(), 0,
                2 * scan.column_period.seconds());
  }
}

using SensorAndSpin = std::tuple<const char*, SpinDirection>;

class PcdSensorOf : public ::testing::TestWithParam<SensorAndSpin> {};

TEST_P(PcdSensorOf, RingsAndTimesOfTheFilesGiveLasersAndRotation) {
  const auto [name, direction] = GetParam();
  const auto truth = sensor(name, direction);
  Recording recording;
  record(truth, Stored::with_rings, true, recording);
  const auto dataset = open_pcd_folder(recording.folder.path(), {});
  const LidarModel& model = *dataset->model();
  EXPECT_EQ(model.direction, direction);
  expect_model(model, *truth);
  ASSERT_TRUE(dataset->model_estimate().has_value());
  EXPECT_EQ(dataset->model_estimate()->scans_used, kScans);
  EXPECT_LT(dataset->model_estimate()->elevation_residual_m, 0.001);
  EXPECT_TRUE(dataset->model_estimate()->azimuths_absolute);
  EXPECT_THAT(dataset->notes(), Contains(HasSubstr("mm")));
  for (std::size_t k = 0; k < kScans; ++k) {
    const LidarScan scan = dataset->read(k);
    EXPECT_EQ(scan.ring_source, Provenance::sensor);
    EXPECT_EQ(scan.time_source, Provenance::sensor);
    expect_own_rays(scan, recording.scans[k], 1e-8);
  }
  // Azimuth offsets, but for the turn common to all.
  const double column_rad = 2 * kPi / model.columns;
  std::vector<double> off;
  for (std::size_t i = 0; i < model.lasers.size(); ++i) {
    off.push_back(model.lasers[i].azimuth_offset_rad - truth->lasers[i].azimuth_offset_rad);
  }
  const auto [least, most] = std::minmax_element(off.begin(), off.end());
  EXPECT_LT(*most - *least, 1.1 * column_rad);
}

TEST_P(PcdSensorOf, RowsOfAnOrganisedCloudAreRings) {
  const auto [name, direction] = GetParam();
  const auto truth = sensor(name, direction);
  Recording recording;
  record(truth, Stored::in_rows, true, recording);
  const auto dataset = open_pcd_folder(recording.folder.path(), {});
  EXPECT_EQ(dataset->model()->direction, direction);
  expect_model(*dataset->model(), *truth);
  const LidarScan scan = dataset->read(1);
  EXPECT_EQ(scan.ring_source, Provenance::recovered_from_order);
  expect_own_rays(scan, recording.scans[1], 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Sensors, PcdSensorOf,
                         ::testing::Combine(::testing::Values("VLP-16", "HDL-32E", "OS1-64"),
                                            ::testing::Values(SpinDirection::clockwise,
                                                              SpinDirection::counter_clockwise)));

TEST(PcdSensor, ALaserWithoutReturnsIsPlacedBetweenItsNeighbours) {
  const auto truth = sensor("VLP-16", SpinDirection::clockwise);
  Recording recording;
  record(truth, Stored::with_rings, true, recording);
  for (int k = 0; k < kScans; ++k) {
    std::vector<LidarRecord>& records = recording.scans[static_cast<std::size_t>(k)].records;
    for (LidarRecord& r : records) {
      if (r.laser != 5) continue;
      r.position_v.setConstant(std::numeric_limits<float>::quiet_NaN());
      r.code = ReturnCode::faulty;
    }
    write_records(recording.folder / (std::to_string(k) + ".pcd"), records, 16, Stored::with_rings, true);
  }
  const auto dataset = open_pcd_folder(recording.folder.path(), {});
  ASSERT_EQ(dataset->model()->lasers.size(), 16U);
  EXPECT_EQ(dataset->model_estimate()->lasers_borrowed, 1);
  EXPECT_NEAR(dataset->model()->lasers[5].elevation_rad, truth->lasers[5].elevation_rad, 0.05 * kDegree);
  expect_own_rays(dataset->read(0), recording.scans[0], 1e-8);
}

TEST(PcdSensor, WithoutTimesTheRotationIsClockwiseAndTheNotesSaySo) {
  LidarModel model = named_model("VLP-16");
  model.start_azimuth_rad = kPi;
  Recording recording;
  record(std::make_shared<const LidarModel>(model), Stored::with_rings, false, recording);
  const auto dataset = open_pcd_folder(recording.folder.path(), {});
  EXPECT_EQ(dataset->model()->direction, SpinDirection::clockwise);
  EXPECT_THAT(dataset->notes(), Contains(HasSubstr("taken as clockwise")));
  expect_model(*dataset->model(), model);
  const LidarScan scan = dataset->read(1);
  EXPECT_EQ(scan.time_source, Provenance::recovered_from_angle);
  std::size_t late = 0;
  for (const LidarReturn& r : scan.returns) {
    const double off_s = (scan.time_of(r) - recording.scans[1].scan->start).seconds() -
                         1e-9 * recording.scans[1].records[r.input_index].time_ns;
    late += std::abs(off_s) > 2 * scan.column_period.seconds() ? 1 : 0;
  }
  // The first and the last column of a scan are adjacent: a point at the seam may belong to either.
  EXPECT_LE(late, 2 * model.lasers.size());
}

TEST(PcdSensor, RingsStoredAsKittiDoesAreFoundByTheirOrder) {
  const LidarModel truth = test::make_bare_cloud_model(16, 1000);
  const test::TemporaryFolder folder;
  std::vector<LidarRecord> records;
  for (const Eigen::Vector3f& p : test::make_bare_cloud(truth, 0)) {
    records.push_back({p, 0, 0, 0, ReturnCode::hit});
  }
  write_records(folder / "0.pcd", records, 1, Stored::in_rows, false);
  write_file_atomically(folder / "times.txt", "1\n");
  const auto dataset = open_pcd_folder(folder.path(), {});
  expect_model(*dataset->model(), truth);
  const LidarScan scan = dataset->read(0);
  EXPECT_EQ(scan.ring_source, Provenance::recovered_from_order);
  ASSERT_EQ(scan.returns.size(), records.size());
  for (const LidarReturn& r : scan.returns) ASSERT_EQ(r.laser, 15 - static_cast<int>(r.input_index) / 1000);
}

std::string refusal(const fs::path& folder) {
  try {
    const auto dataset = open_pcd_folder(folder, {});
    for (std::size_t k = 0; k < dataset->size(); ++k) (void)dataset->read(k);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PcdSensor, SuggestsToNameTheSensorIfNoRingsAreFound) {
  const auto truth = sensor("VLP-16", SpinDirection::clockwise);
  Recording recording;
  record(truth, Stored::in_firing_order, true, recording);
  EXPECT_THAT(refusal(recording.folder.path()), HasSubstr("--sensor"));
  // Rows that are no lasers.
  for (const char* name : {"0.pcd", "1.pcd"}) {
    PcdCloud cloud = read_pcd(recording.folder / name);
    cloud.height = 16;
    cloud.width /= 16;
    write_pcd(recording.folder / name, cloud);
  }
  EXPECT_THAT(refusal(recording.folder.path()), HasSubstr("--sensor"));
}

TEST(PcdSensor, RefusesTimesInAnotherUnitAndScansOfOtherRings) {
  const auto truth = sensor("VLP-16", SpinDirection::clockwise);
  Recording recording;
  record(truth, Stored::with_rings, true, recording);
  std::vector<LidarRecord> microseconds = recording.scans[0].records;
  for (LidarRecord& r : microseconds) r.time_ns /= 1000;
  for (const char* name : {"0.pcd", "1.pcd"}) {
    write_records(recording.folder / name, microseconds, 16, Stored::with_rings, true);
  }
  EXPECT_THAT(refusal(recording.folder.path()), HasSubstr("turns a second"));
  Recording rows;
  record(truth, Stored::in_rows, true, rows);
  const std::vector<LidarRecord>& records = rows.scans[0].records;
  for (int k = 0; k < 9; ++k) {
    // Scan 7 is none of the eight that the sensor is estimated from.
    const std::size_t lasers = k == 7 ? 8 : 16;
    const std::vector<LidarRecord> some(records.begin(),
                                        records.begin() + static_cast<std::ptrdiff_t>(lasers * 1808));
    write_records(rows.folder / (std::to_string(k) + ".pcd"), some, lasers, Stored::in_rows, true);
  }
  write_file_atomically(rows.folder / "times.txt", "0\n0.1\n0.2\n0.3\n0.4\n0.5\n0.6\n0.7\n0.8\n");
  EXPECT_THAT(refusal(rows.folder.path()), HasSubstr("rows = 8"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
