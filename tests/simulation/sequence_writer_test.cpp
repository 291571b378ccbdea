#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "io/formats/pcd/pcd.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr int kScans = 3;

struct Recording {
  Scene scene;
  std::shared_ptr<const LidarModel> model;
  std::vector<SimulatedScan> scans;
  std::unique_ptr<Dataset> read;
};

Recording recorded(const std::string& format, const std::string& sensor,
                   const std::filesystem::path& folder) {
  Recording out;
  SceneOptions options;
  options.duration_s = 0.1 * kScans;
  out.scene = make_scene("flyer", options);
  out.model = std::make_shared<const LidarModel>(model_for_format(named_model(sensor), format));
  SimulatedWorld world(out.scene.world);
  const auto trajectory = std::make_shared<const SampledTrajectory>(out.scene.poses, Duration(), "test");
  SimulatedSensor lidar(out.model, trajectory, world, SensorOptions());
  const auto writer = make_sequence_writer(format, folder, out.model, out.scene);
  for (int k = 0; k < kScans; ++k) {
    out.scans.push_back(lidar.scan(k));
    writer->add(out.scans.back());
  }
  writer->finish();
  DatasetOptions reading;
  reading.format = format;
  out.read = open_dataset(folder, reading);
  return out;
}

class SequenceWriterOfRays : public testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(SequenceWriterOfRays, ReadsBackTheSameCloudsLabelsAndTrajectory) {
  const auto [format, sensor] = GetParam();
  const test::TemporaryFolder folder;
  const Recording recording = recorded(format, sensor, folder.path() / "out");
  ASSERT_EQ(recording.read->size(), static_cast<std::size_t>(kScans));
  const auto poses = recording.scene.poses_in_world();
  const SampledTrajectory truth(poses, Duration(), "truth");
  for (std::size_t k = 0; k < recording.scans.size(); ++k) {
    SCOPED_TRACE(k);
    const SimulatedScan& made = recording.scans[k];
    const LidarScan scan = recording.read->read(k);
    const auto labels = recording.read->read_labels(k);
    ASSERT_TRUE(labels);
    std::size_t hits = 0;
    for (const LidarRecord& r : made.records) hits += r.code == ReturnCode::hit;
    ASSERT_EQ(scan.returns.size(), hits);
    for (const LidarReturn& r : scan.returns) {
      const auto i = static_cast<std::size_t>(r.laser) * static_cast<std::size_t>(recording.model->columns) +
                     static_cast<std::size_t>(r.column);
      ASSERT_LT((r.position_v - made.records[i].position_v).norm(), 1e-3);
      ASSERT_LE(std::abs(scan.time_of(r).nanoseconds() - made.start.nanoseconds() - made.records[i].time_ns),
                100);
      const std::uint32_t expected = made.labels[i];
      ASSERT_EQ(motion_of_label((*labels)[r.input_index]), motion_of_label(expected));
    }
    const Time t = scan.start;
    EXPECT_LT((recording.read->trajectory()->at(t).T_v0.matrix() - truth.at(t).T_v0.matrix()).norm(), 1e-4);
  }
}

using FormatAndSensor = std::pair<std::string, std::string>;
INSTANTIATE_TEST_SUITE_P(Formats, SequenceWriterOfRays,
                         testing::Values(FormatAndSensor("native", "VLP-16"),
                                         FormatAndSensor("native", "HDL-64E-S2"),
                                         FormatAndSensor("mdlidar", "HDL-64E-S2"),
                                         FormatAndSensor("mdlidar", "VLP-16")),
                         [](const auto& one) {
                           std::string name = one.param.first + "_" + one.param.second;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(SequenceWriter, KittiCloudsHaveOneLabelForEachPointAndAreCompensatedToMidScan) {
  const test::TemporaryFolder folder;
  const Recording recording = recorded("kitti", "HDL-64E-S2", folder.path() / "out");
  const SimulatedScan& made = recording.scans[1];
  const std::string bytes = read_whole_file(folder.path() / "out" / "velodyne" / "000001.bin");
  std::size_t hits = 0;
  for (const LidarRecord& r : made.records) hits += r.code == ReturnCode::hit;
  ASSERT_EQ(bytes.size(), 16 * hits);
  EXPECT_EQ(read_label_file(folder.path() / "out" / "labels" / "000001.label", hits).size(), hits);
  const LidarScan scan = recording.read->read(1);
  ASSERT_TRUE(scan.compensated_to);
  EXPECT_EQ(scan.compensated_to->nanoseconds(), 150'000'000);
}

TEST(SequenceWriter, KittiTurnsBeginAtTheRear) {
  const test::TemporaryFolder folder;
  const Recording recording = recorded("kitti", "HDL-64E-S2", folder.path() / "out");
  int near = 0;
  int hits = 0;
  for (const LidarRecord& r : recording.scans[1].records) {
    if (r.code != ReturnCode::hit) continue;
    const double turn = (1 - std::atan2(r.position_v.y(), r.position_v.x()) / std::numbers::pi) / 2;
    ++hits;
    // A laser's azimuth offset of some degrees is a few milliseconds, and wraps at the seam.
    if (std::abs(turn * 0.1 - r.time_ns * 1e-9) < 0.003) ++near;
  }
  EXPECT_GT(near, 0.95 * hits);
}

TEST(SequenceWriter, NamesEveryObjectOnce) {
  const test::TemporaryFolder folder;
  const Recording recording = recorded("native", "VLP-16", folder.path() / "out");
  const std::string table = read_whole_file(folder.path() / "out" / "objects.csv");
  EXPECT_EQ(table.substr(0, 21), "object_id,class,kind\n");
  EXPECT_NE(table.find("\n1,bird,mover\n"), std::string::npos);
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            1 + recording.scene.world.movers.size());
}

/// A car-sized box 10 m ahead of a standing sensor at the origin, one far above it, both 3 m/s along y and
/// turning about z; the world frame of the recording has x, y, z along the level y, z, x.
Scene two_boxes() {
  Scene scene;
  scene.world.shapes.resize(1);
  scene.world.shapes[0].add_box({-2, -1, -1}, {2, 1, 2}, Material::metal);
  const auto add = [&scene](int id, double z) {
    Mover box;
    box.object_id = id;
    box.T_0b = [z](Time t) { return SE3(rotation_z(t.seconds()), {10, 3 * t.seconds(), z}); };
    box.parts.push_back({0, nullptr});
    scene.world.movers.push_back(std::move(box));
  };
  add(4, 0);
  add(2, 500);
  scene.poses = {{Time::from_seconds(-1), SE3()}, {Time::from_seconds(1), SE3()}};
  Eigen::Matrix3d turn;
  turn << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  scene.T_w0 = SE3(turn, {100, 200, 300});
  return scene;
}

TEST(SequenceWriter, WritesTheStateOfEveryVisibleMoverScanByScan) {
  const test::TemporaryFolder folder;
  const Scene scene = two_boxes();
  const auto model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  SimulatedWorld world(scene.world);
  const auto trajectory = std::make_shared<const SampledTrajectory>(scene.poses, Duration(), "test");
  SimulatedSensor lidar(model, trajectory, world, SensorOptions());
  const auto writer = make_sequence_writer("native", folder / "out", model, scene);
  for (int k = 0; k < 2; ++k) writer->add(lidar.scan(k));
  // Not finished, as after a crash.
  const ObjectTruth truth = read_object_truth(folder / "out");
  ASSERT_EQ(truth.states.size(), 2u) << "nothing of the one above is seen";
  for (std::size_t k = 0; k < 2; ++k) {
    SCOPED_TRACE(k);
    const ObjectState& state = truth.states.at({k, 4});
    const double t = 0.05 + 0.1 * static_cast<double>(k);
    EXPECT_DOUBLE_EQ(state.time.seconds(), t);
    // The box is from -1 to 2 in its z: level centre (10, 3 t, 0.5), velocity (0, 3, 0).
    EXPECT_LT((state.centre_0 - Vector3d(100 + 3 * t, 200.5, 310)).norm(), 2e-4);
    EXPECT_LT((state.velocity_0 - Vector3d(3, 0, 0)).norm(), 2e-4);
    EXPECT_NEAR(state.speed_mps, 3, 1e-4);
  }
}

TEST(SequenceWriter, NativeScansKeepTheIntensityOfEveryReturn) {
  const test::TemporaryFolder folder;
  const Recording recording = recorded("native", "VLP-16", folder / "out");
  const PcdCloud cloud = read_pcd(folder / "out/scans/000001.pcd");
  const std::vector<std::int64_t> stored = cloud.integers(cloud.require("intensity"));
  const std::vector<float>& made = recording.scans[1].intensities;
  ASSERT_EQ(stored.size(), made.size());
  std::int64_t highest = 0;
  for (std::size_t i = 0; i < made.size(); ++i) {
    ASSERT_NEAR(static_cast<double>(stored[i]), 255 * made[i], 0.5001);
    highest = std::max(highest, stored[i]);
  }
  EXPECT_GT(highest, 10);
}

TEST(SequenceWriter, RefusesAnExistingFolderAndAnUnknownFormat) {
  const test::TemporaryFolder folder;
  Scene scene;
  const auto model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  EXPECT_THROW((void)make_sequence_writer("native", folder.path(), model, scene), OutputError);
  EXPECT_THROW((void)make_sequence_writer("xyz", folder.path() / "new", model, scene), ParameterError);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "new"));
}

TEST(SequenceWriter, RefusesToWriteWithoutAValidModel) {
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)make_sequence_writer("native", folder / "out", nullptr, Scene{}), ParameterError);
  EXPECT_THROW(
      (void)make_sequence_writer("native", folder / "out", std::make_shared<const LidarModel>(), Scene{}),
      InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
