#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/atomic_file.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/simulation/sequence_writer.hpp>

namespace mapless {
namespace {

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

class SequenceWriterOfRays : public testing::TestWithParam<std::pair<const char*, const char*>> {};

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

INSTANTIATE_TEST_SUITE_P(Formats, SequenceWriterOfRays,
                         testing::Values(std::pair("native", "VLP-16"), std::pair("native", "HDL-64E-S2"),
                                         std::pair("mdlidar", "HDL-64E-S2"), std::pair("mdlidar", "VLP-16")));

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

TEST(SequenceWriter, NamesEveryObjectOnce) {
  const test::TemporaryFolder folder;
  const Recording recording = recorded("native", "VLP-16", folder.path() / "out");
  const std::string table = read_whole_file(folder.path() / "out" / "objects.csv");
  EXPECT_EQ(table.substr(0, 21), "object_id,class,kind\n");
  EXPECT_NE(table.find("\n1,bird,mover\n"), std::string::npos);
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            1 + recording.scene.world.movers.size());
}

TEST(SequenceWriter, RefusesAFolderThatIsThereAndAnUnknownFormat) {
  const test::TemporaryFolder folder;
  Scene scene;
  const auto model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  EXPECT_THROW((void)make_sequence_writer("native", folder.path(), model, scene), OutputError);
  EXPECT_THROW((void)make_sequence_writer("xyz", folder.path() / "new", model, scene), ParameterError);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "new"));
}

}  // namespace
}  // namespace mapless
