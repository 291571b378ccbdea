#include "io/formats/pcd/pcd_folder_dataset.hpp"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/pcd/pcd.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

// One firing of a VLP-16, whose first column may be anywhere in the turn.
struct Firing {
  int laser, column;     // column counted from the model's start, may be beyond one turn
  std::int64_t time_ns;  // since column 0
};

std::vector<Firing> firings(int first_column, int columns) {
  const LidarModel model = named_model("VLP-16");
  std::vector<Firing> out;
  for (int c = first_column; c < first_column + columns; c += 7) {
    for (int laser = 0; laser < 16; ++laser) {
      out.push_back({laser, c,
                     static_cast<std::int64_t>(1e8 / model.columns * c) +
                         model.lasers[static_cast<std::size_t>(laser)].firing_offset.nanoseconds()});
    }
  }
  return out;
}

double range_of(const Firing& f) { return 4 + f.laser + 0.01 * (f.column % 300); }

// What a field of the files holds for a firing.
struct Column {
  std::string name;
  char type;
  std::size_t size;
  std::function<double(const Firing&)> value;
};

void put(std::string& bytes, const Column& column, double value) {
  const auto append = [&bytes](auto v) {
    char raw[sizeof(v)];
    std::memcpy(raw, &v, sizeof(v));
    bytes.append(raw, sizeof(v));
  };
  if (column.type == 'F' && column.size == 4) return append(static_cast<float>(value));
  if (column.type == 'F') return append(value);
  if (column.size == 2) return append(static_cast<std::uint16_t>(value));
  if (column.size == 4) return append(static_cast<std::uint32_t>(value));
  return append(static_cast<std::int64_t>(value));
}

void write_scan(const fs::path& file, const std::vector<Firing>& fired, const std::vector<Column>& columns) {
  const LidarModel model = named_model("VLP-16");
  PcdCloud cloud;
  cloud.width = fired.size();
  cloud.height = 1;
  for (const char* name : {"x", "y", "z"}) cloud.add_field(name, 'F', 4);
  for (const Column& c : columns) cloud.add_field(c.name, c.type, c.size);
  for (const Firing& f : fired) {
    const Eigen::Vector3d p = model.point_v(f.laser, f.column, range_of(f));
    for (const double v : p) put(cloud.bytes, {"", 'F', 4, {}}, v);
    for (const Column& c : columns) put(cloud.bytes, c, c.value(f));
  }
  write_pcd(file, cloud);
}

const Column kRing{"ring", 'U', 2, [](const Firing& f) { return f.laser; }};
const Column kTimeNs{"t", 'U', 4, [](const Firing& f) { return static_cast<double>(f.time_ns); }};

DatasetOptions vlp16() {
  DatasetOptions options;
  options.sensor = "VLP-16";
  return options;
}

LidarScan only_scan(const std::vector<Firing>& fired, const std::vector<Column>& columns) {
  const test::TemporaryFolder folder;
  write_scan(folder / "0.pcd", fired, columns);
  write_file_atomically(folder / "times.txt", "100.5\n");
  return open_pcd_folder(folder.path(), vlp16())->read(0);
}

// Every point came back in its own place: its own laser, its own ray, its own time.
void expect_own_rays(const LidarScan& scan, const std::vector<Firing>& fired, double time_tolerance_ns) {
  ASSERT_EQ(scan.returns.size(), fired.size());
  ASSERT_EQ(scan.input_size, fired.size());
  for (const LidarReturn& r : scan.returns) {
    const Firing& f = fired[r.input_index];
    ASSERT_EQ(r.laser, f.laser);
    ASSERT_NEAR(r.range_m, range_of(f), 1e-4);
    ASSERT_LT(
        (scan.model->point_v(r.laser, r.column, static_cast<double>(r.range_m)) - r.position_v.cast<double>())
            .norm(),
        1e-3);
    const Time truth = Time::from_seconds(100.5) + Duration::from_nanoseconds(f.time_ns);
    ASSERT_NEAR(static_cast<double>((scan.time_of(r) - truth).nanoseconds()), 0, time_tolerance_ns);
    // The column's own time agrees, up to the firing offset within it.
    ASSERT_NEAR((scan.column_time(r.column) - truth).seconds(), 0, 1e-4);
  }
}

TEST(PcdFolder, RingsAndTimesOfTheFilesGiveTheRayOfEveryPoint) {
  const auto fired = firings(0, 1808);
  const LidarScan scan = only_scan(fired, {kRing, kTimeNs});
  EXPECT_EQ(scan.ring_source, Provenance::sensor);
  EXPECT_EQ(scan.time_source, Provenance::sensor);
  expect_own_rays(scan, fired, 1);
}

TEST(PcdFolder, AcceptsScansThatBeginAnywhereAndExceedATurn) {
  const auto fired = firings(1200, 1850);
  const LidarScan scan = only_scan(fired, {kRing, kTimeNs});
  expect_own_rays(scan, fired, 1);
  EXPECT_GT(scan.columns, 1808);
  EXPECT_LT(scan.columns, 1860);
  EXPECT_NEAR((scan.start - Time::from_seconds(100.5)).seconds(), 0.1 * 1200 / 1808, 1e-4);
}

TEST(PcdFolder, EstimatesTheSensorFromScansOfMoreThanATurn) {
  const auto fired = firings(1200, 1850);
  const test::TemporaryFolder folder;
  write_scan(folder / "0.pcd", fired, {kRing, kTimeNs});
  write_file_atomically(folder / "times.txt", "100.5\n");
  const auto dataset = open_pcd_folder(folder.path(), {});
  EXPECT_EQ(dataset->model()->columns, std::lround(1808 / 7.0));  // only every seventh fires here
  EXPECT_NEAR(dataset->model()->rotation_rate_hz, 10, 0.01);
  const LidarScan scan = dataset->read(0);
  ASSERT_EQ(scan.returns.size(), fired.size());
  for (const LidarReturn& r : scan.returns) {
    const Firing& f = fired[r.input_index];
    ASSERT_EQ(r.laser, f.laser);
    const Time truth = Time::from_seconds(100.5) + Duration::from_nanoseconds(f.time_ns);
    ASSERT_NEAR((scan.time_of(r) - truth).seconds(), 0, 1e-8);
    ASSERT_NEAR((scan.column_time(r.column) - truth).seconds(), 0, 2 * scan.column_period.seconds());
  }
}

TEST(PcdFolder, RingsAreFoundFromTheElevation) {
  const auto fired = firings(0, 1808);
  const LidarScan scan = only_scan(fired, {kTimeNs});
  EXPECT_EQ(scan.ring_source, Provenance::recovered_from_angle);
  expect_own_rays(scan, fired, 1);
}

TEST(PcdFolder, TimesAreFoundFromTheAzimuth) {
  const auto fired = firings(0, 1808);
  const LidarScan scan = only_scan(fired, {kRing});
  EXPECT_EQ(scan.time_source, Provenance::recovered_from_angle);
  expect_own_rays(scan, fired, 2000);  // the column period is whole nanoseconds
}

// Its points would get times by their azimuths, among scans whose points have their own.
TEST(PcdFolder, RefusesAScanThatLacksAFieldOfTheOthers) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "times.txt", "100\n100.1\n100.2\n100.3\n");
  const auto fired = firings(0, 1800);
  write_scan(folder / "0.pcd", fired, {kRing, kTimeNs});
  write_scan(folder / "1.pcd", fired, {kRing});
  write_scan(folder / "2.pcd", fired, {kTimeNs});
  write_scan(folder / "3.pcd", fired, {kRing, kTimeNs});
  const auto dataset = open_pcd_folder(folder.path(), vlp16());
  EXPECT_NO_THROW((void)dataset->read(0));
  EXPECT_NO_THROW((void)dataset->read(3));
  const auto refusal = [&](std::size_t k) {
    try {
      (void)dataset->read(k);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal(1), AllOf(HasSubstr("1.pcd"), HasSubstr("no time of each point")));
  EXPECT_THAT(refusal(2), AllOf(HasSubstr("2.pcd"), HasSubstr("no laser (ring) of each point")));
}

// A driver that has lost its packets for a turn.
TEST(PcdFolder, AScanWithoutPointsHasTheFieldsOfTheOthers) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "times.txt", "100\n100.1\n100.2\n");
  const std::vector<Firing> fired = firings(0, 1808);
  write_scan(folder / "0.pcd", {}, {kRing, kTimeNs});
  write_scan(folder / "1.pcd", fired, {kRing, kTimeNs});
  write_scan(folder / "2.pcd", {}, {kRing, kTimeNs});
  const auto dataset = open_pcd_folder(folder.path(), vlp16());
  EXPECT_TRUE(dataset->read(0).returns.empty());
  EXPECT_FALSE(dataset->read(1).returns.empty());
  EXPECT_TRUE(dataset->read(2).returns.empty());
}

TEST(PcdFolder, AcceptsRingsCountedFromTheTop) {
  const auto fired = firings(0, 1808);
  const Column from_top{"ring", 'U', 2, [](const Firing& f) { return 15 - f.laser; }};
  expect_own_rays(only_scan(fired, {from_top, kTimeNs}), fired, 1);
}

TEST(PcdFolder, AcceptsTimesInSecondsAndAbsoluteTimes) {
  const auto fired = firings(0, 1808);
  const auto seconds = [](const Firing& f) { return 1e-9 * static_cast<double>(f.time_ns); };
  expect_own_rays(only_scan(fired, {kRing, {"time", 'F', 4, seconds}}), fired, 20);
  // Absolute times overrule the start of the scan.
  const auto start_ns = [](const LidarScan& scan) { return scan.start.nanoseconds(); };
  const LidarScan absolute =
      only_scan(fired, {kRing, {"timestamp", 'F', 8, [&](const Firing& f) { return 1.7e9 + seconds(f); }}});
  EXPECT_NEAR(static_cast<double>(start_ns(absolute) - INT64_C(1'700'000'000'000'000'000)), 0, 300);
  const LidarScan nanoseconds =
      only_scan(fired, {kRing, {"t", 'I', 8, [](const Firing& f) {
                                  return 1.7e18 + 512 * std::floor(static_cast<double>(f.time_ns) / 512);
                                }}});
  EXPECT_NEAR(static_cast<double>(start_ns(nanoseconds) - INT64_C(1'700'000'000'000'000'000)), 0, 600);
  EXPECT_EQ(nanoseconds.returns.size(), fired.size());
}

TEST(PcdFolder, TakesStartsFromNamesOrPointsWithoutATimesFile) {
  const auto fired = firings(0, 1808);
  const test::TemporaryFolder folder;
  write_scan(folder / "1700000000000000001.pcd", fired, {kRing});
  write_scan(folder / "1700000000100000001.pcd", fired, {kRing});
  ASSERT_TRUE(looks_pcd_folder(folder.path()));
  EXPECT_EQ(open_pcd_folder(folder.path(), vlp16())->scan_start(1).nanoseconds(), 1'700'000'000'100'000'001);
  const test::TemporaryFolder seconds;
  write_scan(seconds / "1700000000.25.pcd", fired, {kRing});
  EXPECT_EQ(open_pcd_folder(seconds.path(), vlp16())->scan_start(0).nanoseconds(), 1'700'000'000'250'000'000);
  const test::TemporaryFolder points;
  const auto absolute = [](const Firing& f) { return 1.7e9 + 1e-9 * static_cast<double>(f.time_ns); };
  write_scan(points / "000000.pcd", fired, {kRing, {"timestamp", 'F', 8, absolute}});
  EXPECT_NEAR(open_pcd_folder(points.path(), vlp16())->scan_start(0).seconds(), 1.7e9, 1e-6);
}

TEST(PcdFolder, NumbersNeedNoLeadingZeros) {
  const auto fired = firings(0, 1808);
  const test::TemporaryFolder folder;
  for (const char* name : {"10.pcd", "9.pcd", "100.pcd"}) write_scan(folder / name, fired, {kRing});
  write_file_atomically(folder / "times.txt", "0.0\n0.1\n0.2\n");
  const auto dataset = open_pcd_folder(folder.path(), vlp16());
  EXPECT_EQ(dataset->scan_file(0).filename(), "9.pcd");
  EXPECT_EQ(dataset->scan_file(1).filename(), "10.pcd");
  EXPECT_EQ(dataset->scan_file(2).filename(), "100.pcd");
}

TEST(PcdFolder, PointsWithoutPositionKeepTheirInputIndex) {
  const test::TemporaryFolder folder;
  const auto fired = firings(0, 1808);
  write_scan(folder / "0.pcd", fired, {kRing, kTimeNs});
  PcdCloud cloud = read_pcd(folder / "0.pcd");
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  std::memcpy(cloud.bytes.data() + 3 * cloud.stride, &nan, 4);
  std::memcpy(cloud.bytes.data() + 5 * cloud.stride, &inf, 4);
  write_pcd(folder / "0.pcd", cloud);
  write_file_atomically(folder / "times.txt", "1\n");
  fs::create_directory(folder / "labels");
  write_label_file(folder / "labels/0.label", std::vector<std::uint32_t>(fired.size(), kLabelStatic));
  const auto dataset = open_pcd_folder(folder.path(), vlp16());
  const LidarScan scan = dataset->read(0);
  EXPECT_EQ(scan.input_size, fired.size());
  EXPECT_EQ(scan.returns.size(), fired.size() - 2);
  EXPECT_EQ(dataset->read_labels(0)->size(), fired.size());
}

TEST(PcdFolder, RefusesUnreadableFiles) {
  const auto refusal = [](const std::vector<Column>& columns,
                          const std::function<void(const fs::path&)>& damage,
                          const DatasetOptions& options = vlp16()) -> std::string {
    const test::TemporaryFolder folder;
    write_scan(folder / "0.pcd", firings(0, 1808), columns);
    write_scan(folder / "1.pcd", firings(0, 1808), columns);
    write_file_atomically(folder / "times.txt", "1\n2\n");
    damage(folder.path());
    try {
      const auto dataset = open_pcd_folder(folder.path(), options);
      (void)dataset->read(0);
      (void)dataset->read(1);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto nothing = [](const fs::path&) {};
  const auto constant = [](double v) { return [v](const Firing&) { return v; }; };
  EXPECT_EQ(refusal({kRing}, nothing), "accepted");
  EXPECT_THAT(refusal({}, nothing, {}), HasSubstr("--sensor"));
  EXPECT_THAT(refusal({}, [](const fs::path& r) { fs::remove(r / "times.txt"); }),
              AllOf(HasSubstr("0.pcd"), HasSubstr("times.txt")));
  EXPECT_THAT(refusal({}, [](const fs::path& r) { write_file_atomically(r / "times.txt", "2\n1\n"); }),
              HasSubstr("times.txt:2"));
  EXPECT_THAT(refusal({}, [](const fs::path& r) { fs::resize_file(r / "1.pcd", 5000); }), HasSubstr("1.pcd"));
  EXPECT_THAT(refusal({}, [](const fs::path& r) { fs::resize_file(r / "1.pcd", 0); }), HasSubstr("0 bytes"));
  EXPECT_THAT(refusal({{"ring", 'U', 2, constant(16)}}, nothing), HasSubstr("ring = 16"));
  EXPECT_THAT(refusal({{"ring", 'U', 2, constant(3)}}, nothing), HasSubstr("off its beams"));
  EXPECT_THAT(refusal({{"t", 'F', 4, constant(NAN)}}, nothing), HasSubstr("point 0 time = nan"));
  EXPECT_THAT(refusal({{"t", 'F', 4, constant(1.7e9)}}, nothing), HasSubstr("4 bytes"));
  EXPECT_THAT(refusal({{"t", 'I', 8, constant(-9.1e18)}}, nothing), HasSubstr("not a time in nanoseconds"));
  const auto microseconds_as_seconds = [](const Firing& f) { return 1e-3 * static_cast<double>(f.time_ns); };
  EXPECT_THAT(refusal({{"t", 'F', 8, microseconds_as_seconds}}, nothing), HasSubstr("more than three turns"));
  DatasetOptions other;
  other.sensor = "HDL-32E";
  EXPECT_THAT(refusal({}, nothing, other), HasSubstr("off its beams"));
  other.sensor = "VLP-16";
  other.labels = "/no/such/folder";
  EXPECT_THAT(refusal({}, nothing, other), HasSubstr("/no/such/folder"));
}

TEST(PcdFolder, IsDistinguishedFromANativeRecording) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(looks_pcd_folder(folder.path()));
  EXPECT_FALSE(looks_pcd_folder(folder / "none"));
  write_scan(folder / "a.pcd", firings(0, 7), {});
  EXPECT_TRUE(looks_pcd_folder(folder.path()));
  write_file_atomically(folder / "sensor.yaml", "");
  EXPECT_FALSE(looks_pcd_folder(folder.path()));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
