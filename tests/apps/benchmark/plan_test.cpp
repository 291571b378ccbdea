#include "benchmark/plan.hpp"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

std::vector<Job> of_part(const std::vector<Job>& jobs, Part part) {
  std::vector<Job> out;
  for (const Job& job : jobs) {
    if (job.part == part) out.push_back(job);
  }
  return out;
}

std::set<RecordingKey> recordings(const std::vector<Job>& jobs) {
  std::set<RecordingKey> out;
  for (const Job& job : jobs) out.insert(job.recording);
  return out;
}

TEST(BenchmarkPlan, TheDeclaredTableHasAllScenesThreeNoisesAndFourSensors) {
  const auto table = of_part(make_plan({}), Part::table);
  std::set<std::string> scenes, sensors;
  std::set<double> town_noises;
  for (const Job& job : table) {
    sensors.insert(job.recording.sensor);
    if (job.recording.sensor != "HDL-64E-S2") continue;
    if (job.recording.range_noise_m == 0.02) scenes.insert(job.recording.scene);
    if (job.recording.scene == "town2") town_noises.insert(job.recording.range_noise_m);
  }
  std::set<std::string> fixed(scene_names().begin(), scene_names().end());
  EXPECT_EQ(fixed.erase("random"), 1u) << "another place with every seed";
  EXPECT_EQ(scenes, fixed);
  EXPECT_EQ(town_noises, (std::set<double>{0, 0.02, 0.05}));
  EXPECT_EQ(sensors, (std::set<std::string>{"HDL-64E-S2", "VLP-16", "Pandar64", "OS1-128"}));
  EXPECT_EQ(recordings(table).size(), table.size()) << "each once";
}

TEST(BenchmarkPlan, SweepsBothTownsAtEveryNoise) {
  const auto keys = recordings(of_part(make_plan({}), Part::sweep));
  EXPECT_EQ(keys.size(), 6u);
  for (const RecordingKey& key : keys) EXPECT_THAT(key.scene, testing::StartsWith("town"));
}

TEST(BenchmarkPlan, WhatIsChosenIsMultiplied) {
  PlanOptions options;
  options.scenes = {"flyer", "forest"};
  options.range_noises_m = {0, 0.1};
  options.seeds = {1, 2, 3};
  options.duration_s = 7;
  options.odometry = true;
  const auto jobs = make_plan(options);
  EXPECT_EQ(of_part(jobs, Part::table).size(), 2u * 2 * 3 * 2);
  EXPECT_EQ(recordings(jobs).size(), 2u * 2 * 3);
  for (const RecordingKey& key : recordings(of_part(jobs, Part::sweep))) {
    EXPECT_EQ(key.scene, "flyer") << "no town is there: the first scene";
    EXPECT_EQ(key.seed, 1u);
    EXPECT_EQ(key.duration_s, 7);
  }
}

TEST(BenchmarkPlan, ASensorFileAndFaultyReturnsMakeOtherRecordings) {
  const test::TemporaryFolder folder;
  const auto plan = [&](int columns, const std::string& faulty) {
    LidarModel model = named_model("VLP-16");
    model.columns = columns;
    write_sensor_yaml(folder / "roof lidar.yaml", model);
    PlanOptions options;
    options.sensors = {folder / "roof lidar.yaml"};
    options.faulty = faulty;
    return make_plan(options).front().recording;
  };
  const RecordingKey with = plan(900, "on"), without = plan(900, "off"), other = plan(800, "on");
  EXPECT_EQ(with.sensor, "roof lidar");
  EXPECT_EQ(other.model().columns, 800);
  EXPECT_FALSE(without.faulty);
  const std::set<std::string> names = {with.name(), without.name(), other.name()};
  EXPECT_EQ(names.size(), 3u);
  for (const std::string& name : names) EXPECT_EQ(name.find_first_of(" /"), std::string::npos) << name;
}

TEST(BenchmarkPlan, EveryRunHasAFileOfItsOwn) {
  PlanOptions options;
  options.odometry = true;
  const auto jobs = make_plan(options);
  std::set<std::string> stems;
  for (const Job& job : jobs) stems.insert(job.stem());
  EXPECT_EQ(stems.size(), jobs.size());
}

TEST(BenchmarkPlan, OneThresholdMovesAllOthersInProportion) {
  DetectorParameters p;
  p.comparison.error_threshold_m = 0.2;
  p.freespace.backward_threshold_m = 0.2;
  p.freespace.forward_threshold_m = 0.1;
  const DetectorParameters swept = with_error_threshold(p, 0.5);
  EXPECT_DOUBLE_EQ(swept.voting.tolerance_m, 2.5 * DetectorParameters{}.voting.tolerance_m);
  EXPECT_DOUBLE_EQ(swept.voting.tolerance_spacings, 2.5 * DetectorParameters{}.voting.tolerance_spacings);
  EXPECT_DOUBLE_EQ(swept.comparison.error_threshold_m, 0.5);
  EXPECT_DOUBLE_EQ(swept.freespace.backward_threshold_m, 0.5);
  EXPECT_DOUBLE_EQ(swept.freespace.forward_threshold_m, 0.25);
  // The paper's profile has one threshold for all, and keeps it so.
  const DetectorParameters paper = with_error_threshold(detector_profile("paper"), 0.3);
  EXPECT_DOUBLE_EQ(paper.freespace.backward_threshold_m, 0.3);
  EXPECT_DOUBLE_EQ(paper.freespace.forward_threshold_m, 0.3);
}

TEST(BenchmarkPlan, AnAblationTakesOneThingAway) {
  PlanOptions options;
  options.quick = true;
  const auto jobs = of_part(make_plan(options), Part::ablation);
  ASSERT_EQ(jobs.size(), 9u);
  const Job& whole = jobs.front();
  for (std::size_t i = 1; i < jobs.size(); ++i) {
    const bool same_parameters = jobs[i].json()["parameters"] == whole.json()["parameters"];
    EXPECT_NE(same_parameters, jobs[i].compensation == Compensation::full) << jobs[i].name;
  }
}

TEST(BenchmarkPlan, ParametersAreRefusedAsDetectRefusesThem) {
  PlanOptions options;
  options.parameters.settings = {"scan_gap=0"};
  EXPECT_THROW(static_cast<void>(make_plan(options)), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
