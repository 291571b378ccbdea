#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "benchmark/speed/speed_plots.hpp"
#include "benchmark/speed/speed_sensor.hpp"
#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::CommandResult;
using test::run_command;
using testing::HasSubstr;

TEST(BenchmarkSpeed, TellsEveryStageBesideTheYardstick) {
  const test::TemporaryFolder folder;
  const std::string few_rays = "OS1-64x128";
  const CommandResult result = run_command({"benchmark", "--speed", "--sensors", few_rays, "--duration-s",
                                            "4.5", "--json", "--threads", "1", "-o", folder / "speed"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto all = nlohmann::json::parse(result.out);
  ASSERT_EQ(all["sensors"].size(), 1u);
  const auto& sensor = all["sensors"][0];
  EXPECT_EQ(sensor["sensor"], few_rays);
  constexpr double rays = 64 * 128;
  EXPECT_EQ(sensor["rays"], rays);
  EXPECT_EQ(sensor["scans"], 45 - 33);
  std::map<std::string, nlohmann::json> rows;
  for (const auto& row : sensor["rows"]) rows[row["name"]] = row;
  for (const char* name : {"compensation", "evidence", "filter", "region growth", "detection", "odometry",
                           "pipeline", "on two threads", "tracking", "yardstick"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(rows.count(name), 1u);
    const nlohmann::json& row = rows[name];
    const double median_ms = row["median_ms"];
    EXPECT_GT(median_ms, 0);
    EXPECT_LE(median_ms, row["p95_ms"]);
    EXPECT_LE(row["p95_ms"], row["p99_ms"]);
    EXPECT_NEAR(row["ns_per_ray"], median_ms * 1e6 / rays, 1e-6);
  }
  EXPECT_EQ(rows.size(), 10u);
  EXPECT_DOUBLE_EQ(rows["yardstick"]["yardsticks"], 1);
  EXPECT_DOUBLE_EQ(rows["detection"]["share_of_detection"], 1);
  EXPECT_LT(rows["evidence"]["median_ms"], rows["detection"]["median_ms"]);
  EXPECT_LT(rows["odometry"]["median_ms"], rows["pipeline"]["median_ms"]);
  EXPECT_GT(rows["on two threads"]["processor_ms"], 0);
  EXPECT_TRUE(rows["evidence"]["processor_ms"].is_null());
  ASSERT_EQ(sensor["threads"].size(), 2u);
  EXPECT_EQ(sensor["threads"][0]["side_by_side"], false);
  EXPECT_EQ(sensor["threads"][1]["threads"], 2);
  EXPECT_EQ(sensor["threads"][1]["median_ms"], rows["on two threads"]["median_ms"]);
  EXPECT_EQ(read_whole_file(folder / "speed" / "speed.json"), result.out);
  for (const char* file : {"time_against_rays.png", "time_against_threads.png"})
    EXPECT_THAT(read_whole_file(folder / "speed" / file), testing::StartsWith("\x89PNG")) << file;
}

TEST(BenchmarkSpeed, ADriveTooShortIsRefused) {
  const CommandResult result = run_command({"benchmark", "--speed", "--duration-s", "3"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--duration-s"));
  EXPECT_THAT(result.err, HasSubstr("too short"));
}

TEST(BenchmarkSpeed, AnOusterHasAsManyColumnsAsAsked) {
  EXPECT_EQ(app::speed_sensor("OS1-128x2048").columns, 2048);
  EXPECT_EQ(app::speed_sensor("OS1-128x2048").lasers.size(), 128u);
  EXPECT_EQ(app::speed_sensor("OS1-128").columns, 1024);
  for (const char* name : {"OS1-128x", "OS1-128x0", "OS1-128x12k", "VLP-16x900", "OS2x12"})
    EXPECT_THROW((void)app::speed_sensor(name), ParameterError) << name;
}

// Two sensors, the larger first.
nlohmann::ordered_json made_figures() {
  const auto rows = [](double ms) {
    nlohmann::ordered_json all;
    for (const char* name : {"pipeline", "on two threads", "detection", "odometry"})
      all.push_back({{"name", name}, {"processor_ms", ms++}});
    return all;
  };
  const nlohmann::ordered_json threads = {{{"threads", 1}, {"side_by_side", false}, {"median_ms", 60}},
                                          {{"threads", 2}, {"side_by_side", true}, {"median_ms", 40}},
                                          {{"threads", 2}, {"side_by_side", false}, {"median_ms", 50}}};
  return {{"scene", "town1"},
          {"sensors",
           {{{"sensor", "B"}, {"rays", 100'000}, {"rows", rows(60)}, {"threads", threads}},
            {{"sensor", "A"}, {"rays", 30'000}, {"rows", rows(20)}, {"threads", threads}}}}};
}

TEST(BenchmarkSpeed, PlotsTimeAgainstRaysAndThreads) {
  const app::Plot rays = app::time_against_rays(made_figures());
  ASSERT_EQ(rays.lines.size(), 4u);
  EXPECT_EQ(rays.lines[0].point_names, (std::vector<std::string>{"A", "B"}));
  using Points = std::vector<std::pair<double, double>>;
  EXPECT_EQ(rays.lines[0].points, (Points{{30, 20}, {100, 60}}));
  EXPECT_EQ(rays.lines[3].points, (Points{{30, 23}, {100, 63}}));
  EXPECT_GE(rays.y.to, 63);
  const app::Plot threads = app::time_against_threads(made_figures());
  ASSERT_EQ(threads.lines.size(), 2u);
  EXPECT_EQ(threads.lines[0].points, (Points{{1, 60}, {2, 50}}));
  EXPECT_EQ(threads.lines[1].points, (Points{{2, 40}}));
}

TEST(BenchmarkSpeed, WithoutItAnOutputIsRequired) {
  const CommandResult result = run_command({"benchmark", "--quick"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--output"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
