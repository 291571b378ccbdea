#include "io/formats/native/native_dataset.hpp"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/native/native_writer.hpp"
#include "io/formats/pcd/pcd.hpp"
#include "io/tables/scan_times.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kColumns = 50;

LidarModel small_model() {
  LidarModel model;
  model.name = "small";
  model.columns = kColumns;
  model.start_azimuth_rad = 1;
  model.max_range_m = 100;
  model.lasers.resize(3);
  model.lasers[0].elevation_rad = -0.2;
  model.lasers[1].elevation_rad = -0.1;
  model.lasers[1].azimuth_offset_rad = 0.03;
  model.lasers[2].origin_h_m = {0.02, 0.03, 0.2};
  model.lasers[2].firing_offset = Duration::from_nanoseconds(1500);
  return model;
}

// A hit on every firing but for three.
std::vector<LidarRecord> firings(int scan) {
  const LidarModel model = small_model();
  std::vector<LidarRecord> records;
  for (int laser = 0; laser < 3; ++laser) {
    for (int column = 0; column < kColumns; ++column) {
      const double range_m = 5 + scan + laser + 0.1 * column;
      records.push_back({model.point_v(laser, column, range_m).cast<float>(), laser, column,
                         2'000'000 * column + 100 * laser, ReturnCode::hit});
    }
  }
  records[5].code = ReturnCode::faulty;
  records[6].code = ReturnCode::nothing;
  records.pop_back();  // the last firing is not in the recording
  return records;
}

std::vector<std::uint32_t> labels_of(const std::vector<LidarRecord>& records) {
  std::vector<std::uint32_t> labels;
  for (const LidarRecord& r : records) {
    labels.push_back(r.laser == 1 ? kLabelDynamic | 1u << 16 : kLabelStatic);
  }
  return labels;
}

void write_recording(const fs::path& folder, int scans = 2) {
  NativeWriter writer(folder, small_model());
  for (int k = 0; k < scans; ++k) {
    writer.add_scan(Time::from_nanoseconds(1'317'042'272'283'701'593 + k * INT64_C(100'000'000)), firings(k),
                    labels_of(firings(k)));
  }
  writer.finish({});
}

// The error of opening and reading a recording after `damage`.
std::string refusal(const std::function<void(const fs::path&)>& damage, const DatasetOptions& options = {}) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r");
  damage(folder / "r");
  try {
    const auto dataset = open_native(folder / "r", options);
    for (std::size_t k = 0; k < dataset->size(); ++k) {
      (void)dataset->read(k);
      (void)dataset->read_labels(k);
    }
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

void edit_scan(const fs::path& file, const std::function<void(PcdCloud&)>& edit) {
  PcdCloud cloud = read_pcd(file);
  edit(cloud);
  write_pcd(file, cloud);
}

TEST(NativeDataset, ReadsBackTheWrittenScans) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r");
  ASSERT_TRUE(looks_native(folder / "r"));
  const auto dataset = open_native(folder / "r", {});
  EXPECT_EQ(dataset->format(), "native");
  ASSERT_EQ(dataset->size(), 2u);
  EXPECT_EQ(dataset->scan_start(1).nanoseconds(), 1'317'042'272'383'701'593);
  EXPECT_EQ(dataset->scan_end(0), dataset->scan_start(1));
  EXPECT_EQ(dataset->trajectory(), nullptr);
  const LidarScan scan = dataset->read(1);
  EXPECT_EQ(scan.start, dataset->scan_start(1));
  EXPECT_EQ(scan.end(), dataset->scan_end(1));
  EXPECT_EQ(scan.time_source, Provenance::sensor);
  EXPECT_EQ(scan.ring_source, Provenance::sensor);
  EXPECT_FALSE(scan.compensated_to);
  EXPECT_EQ(scan.input_size, 3u * kColumns);
  const std::vector<LidarRecord> written = firings(1);
  ASSERT_EQ(scan.returns.size(), written.size() - 2);
  for (const LidarReturn& r : scan.returns) {
    const LidarRecord& w = written[r.input_index];
    EXPECT_EQ(r.position_v, w.position_v);
    EXPECT_EQ(r.time_ns, w.time_ns);
    EXPECT_EQ(r.laser, w.laser);
    EXPECT_EQ(r.column, w.column);
    EXPECT_NEAR(r.range_m, 6 + w.laser + 0.1 * w.column, 1e-5);
  }
  EXPECT_EQ(code_of_cell(scan.cell(0, 5)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 6)), ReturnCode::nothing);
  EXPECT_EQ(code_of_cell(scan.cell(2, kColumns - 1)), ReturnCode::faulty);
  std::vector<std::uint32_t> labels = labels_of(written);
  labels.push_back(kLabelUnknown);
  EXPECT_EQ(dataset->read_labels(1), labels);
}

TEST(NativeDataset, WithoutATimeFieldTimesAreThoseOfTheColumns) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r", 1);
  edit_scan(folder / "r/scans/000000.pcd", [](PcdCloud& cloud) { cloud.fields[3].name = "other"; });
  const LidarScan scan = open_native(folder / "r", {})->read(0);
  EXPECT_EQ(scan.time_source, Provenance::recovered_from_order);
  for (const LidarReturn& r : scan.returns)
    EXPECT_EQ(r.time_ns, 2'000'000 * r.column + (r.laser == 2 ? 1500 : 0));
}

TEST(NativeDataset, WithoutACodeFieldNanPointsAreFaultyAndOtherFieldsAreIgnored) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r", 1);
  edit_scan(folder / "r/scans/000000.pcd", [](PcdCloud& cloud) { cloud.fields[4].name = "intensity"; });
  const LidarScan scan = open_native(folder / "r", {})->read(0);
  EXPECT_EQ(code_of_cell(scan.cell(0, 5)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 6)), ReturnCode::faulty);
}

TEST(NativeDataset, InfiniteAndNotFinitePointsOfHitsAreFaulty) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r", 1);
  edit_scan(folder / "r/scans/000000.pcd", [](PcdCloud& cloud) {
    for (const auto& [cell, value] : {std::pair{10, std::numeric_limits<float>::infinity()},
                                      std::pair{11, std::numeric_limits<float>::quiet_NaN()}}) {
      std::memcpy(cloud.bytes.data() + static_cast<std::size_t>(cell) * cloud.stride + 4, &value, 4);
    }
  });
  const LidarScan scan = open_native(folder / "r", {})->read(0);
  EXPECT_EQ(code_of_cell(scan.cell(0, 10)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 11)), ReturnCode::faulty);
  EXPECT_EQ(code_of_cell(scan.cell(0, 12)), ReturnCode::hit);
}

TEST(NativeDataset, InvalidScansAreRefused) {
  EXPECT_EQ(refusal([](const fs::path&) {}), "accepted");
  EXPECT_THAT(refusal([](const fs::path& r) { fs::resize_file(r / "scans/000001.pcd", 900); }),
              AllOf(HasSubstr("000001.pcd"), HasSubstr("DATA")));
  EXPECT_THAT(refusal([](const fs::path& r) { fs::resize_file(r / "scans/000001.pcd", 0); }),
              AllOf(HasSubstr("000001.pcd"), HasSubstr("0 bytes")));
  const auto with_edit = [](const std::function<void(PcdCloud&)>& edit) {
    return refusal([&](const fs::path& r) { edit_scan(r / "scans/000001.pcd", edit); });
  };
  EXPECT_THAT(with_edit([](PcdCloud& c) { std::swap(c.width, c.height); }),
              AllOf(HasSubstr("HEIGHT = 50"), HasSubstr("3 lasers")));
  EXPECT_THAT(with_edit([](PcdCloud& c) {
                c.width = kColumns - 1;
                c.bytes.resize(c.size() * c.stride);
              }),
              AllOf(HasSubstr("WIDTH = 49"), HasSubstr("50 columns")));
  EXPECT_THAT(with_edit([](PcdCloud& c) { c.fields[1].name = "why"; }), HasSubstr("no field 'y'"));
  EXPECT_THAT(with_edit([](PcdCloud& c) { c.bytes[16] = 3; }), HasSubstr("point 0 code = 3"));
  EXPECT_THAT(with_edit([](PcdCloud& c) { c.bytes[15] = '\xff'; }), HasSubstr("point 0 t = 42"));
  EXPECT_THAT(with_edit([](PcdCloud& c) { c.bytes[15] = '\x7f'; }), HasSubstr("time [ns] = 21"));
}

TEST(NativeDataset, InvalidTimesAreRefused) {
  const auto with_times = [](const std::string& text) {
    return refusal([&](const fs::path& r) { write_file_atomically(r / "times.txt", text); });
  };
  EXPECT_EQ(with_times("# start\n0.5\n\n0.6  # the second\n"), "accepted");
  EXPECT_THAT(refusal([](const fs::path& r) { fs::remove(r / "times.txt"); }), HasSubstr("times.txt"));
  EXPECT_THAT(with_times("0.5\n"),
              AllOf(HasSubstr("times.txt"), HasSubstr("times = 1"), HasSubstr("2 scans")));
  EXPECT_THAT(with_times(""), HasSubstr("times = 0"));
  EXPECT_THAT(with_times("0.5\n0.6\n0.7\n"), HasSubstr("times = 3"));
  EXPECT_THAT(with_times("0.5\n0.4\n"),
              AllOf(HasSubstr("times.txt:2"), HasSubstr("0.4"), HasSubstr("not after")));
  EXPECT_THAT(with_times("0.5\n0.5\n"), HasSubstr("not after"));
  EXPECT_THAT(with_times("0.5\nnan\n"), HasSubstr("nan"));
  EXPECT_THAT(with_times("0.5 0.6\n"), HasSubstr("not one number"));
}

TEST(NativeDataset, InvalidFoldersAreRefused) {
  EXPECT_THAT(refusal([](const fs::path& r) { fs::remove(r / "sensor.yaml"); }), HasSubstr("sensor.yaml"));
  EXPECT_THAT(refusal([](const fs::path& r) {
                fs::remove(r / "scans/000000.pcd");
                fs::remove(r / "scans/000001.pcd");
              }),
              HasSubstr("scans"));
  EXPECT_THAT(refusal([](const fs::path& r) { write_file_atomically(r / "labels/000001.label", "1234"); }),
              AllOf(HasSubstr("000001.label"), HasSubstr("150 points")));
  DatasetOptions options;
  options.sensor = "VLP-16";
  EXPECT_THAT(refusal([](const fs::path&) {}, options), HasSubstr("HEIGHT = 3"));
  options = {};
  options.labels = "/no/such/folder";
  EXPECT_THAT(refusal([](const fs::path&) {}, options), HasSubstr("/no/such/folder"));
  EXPECT_FALSE(looks_native("/no/such/folder"));
}

TEST(NativeDataset, LabelsMayComeFromAnotherFolderOrBeMissing) {
  const test::TemporaryFolder folder;
  write_recording(folder / "r");
  fs::remove(folder / "r/labels/000000.label");
  fs::create_directory(folder / "truth");
  DatasetOptions options;
  EXPECT_EQ(open_native(folder / "r", options)->read_labels(0), std::nullopt);
  EXPECT_TRUE(open_native(folder / "r", options)->read_labels(1));
  options.labels = folder / "truth";
  write_label_file(folder / "truth/000000.label", std::vector<std::uint32_t>(3 * kColumns, kLabelStatic));
  EXPECT_TRUE(open_native(folder / "r", options)->read_labels(0));
  EXPECT_EQ(open_native(folder / "r", options)->read_labels(1), std::nullopt);
}

TEST(NativeWriter, RefusesScansThatCouldNotBeReadBack) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "there");
  EXPECT_THROW(NativeWriter(folder / "there", small_model()), OutputError);
  write_file_atomically(folder / "file", "");
  EXPECT_THROW(NativeWriter(folder / "file/inside", small_model()), OutputError);
  EXPECT_THROW(NativeWriter(folder / "new", LidarModel()), InputError);
  EXPECT_FALSE(fs::exists(folder / "new"));
  NativeWriter writer(folder / "r", small_model());
  const Time t = Time::from_seconds(5);
  std::vector<LidarRecord> records = firings(0);
  EXPECT_THROW(writer.add_scan(t, records, {1, 2}), InputError);
  records[0].column = 1;
  EXPECT_THROW(writer.add_scan(t, records), InputError);
  records[0].column = kColumns;
  EXPECT_THROW(writer.add_scan(t, records), InputError);
  EXPECT_TRUE(fs::is_empty(folder / "r/scans"));
  writer.add_scan(t, firings(0));
  EXPECT_THROW(writer.add_scan(t, firings(0)), InputError);
  EXPECT_FALSE(fs::exists(folder / "r/times.txt"));
}

TEST(NativeWriter, AcceptsLasersThatFireBeforeTheStartOfTheScan) {
  const test::TemporaryFolder folder;
  NativeWriter writer(folder / "r", small_model());
  std::vector<LidarRecord> records = firings(0);
  records[0].time_ns = -54'668;
  writer.add_scan(Time(), records);
  writer.finish({});
  EXPECT_EQ(open_native(folder / "r", {})->read(0).returns[0].time_ns, -54'668);
}

TEST(NativeWriter, TrajectoryIsThatOfTheRecording) {
  const test::TemporaryFolder folder;
  NativeWriter writer(folder / "r", small_model());
  writer.add_scan(Time(), firings(0));
  const SE3 T_0v(rotation_z(0.4), {1, 2, 3});
  writer.finish({{Time(), SE3()}, {Time::from_seconds(1), T_0v.inverse()}});
  const auto trajectory = open_native(folder / "r", {})->trajectory();
  ASSERT_NE(trajectory, nullptr);
  EXPECT_EQ(trajectory->end(), Time::from_seconds(1));
  const SE3 back = trajectory->at(Time::from_seconds(1)).T_v0.inverse();
  EXPECT_LT((back.translation() - T_0v.translation()).norm(), 1e-6);
  EXPECT_LT((back.rotation() - T_0v.rotation()).norm(), 1e-6);
}

// As where the disk is full then.
TEST(NativeDataset, WithoutSpaceForLabelsItEndsWithTheScanBefore) {
  const test::TemporaryFolder parent;
  const fs::path folder = parent / "recording";
  NativeWriter writer(folder, small_model());
  const std::vector<LidarRecord> records = firings(0);
  const std::vector<std::uint32_t> labels(records.size(), kLabelStatic);
  writer.add_scan(Time(), records, labels);
  fs::create_directory(folder / "labels/000001.label");
  EXPECT_THROW(writer.add_scan(Time::from_seconds(0.1), records, labels), OutputError);
  writer.finish({});
  EXPECT_EQ(open_native(folder, {})->size(), 1u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
