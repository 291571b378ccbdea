#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace {

using test::CommandResult;
using test::run_command;
using testing::HasSubstr;

TEST(BenchmarkSpeed, TellsEveryStageBesideTheYardstick) {
  const CommandResult result =
      run_command({"benchmark", "--speed", "--sensors", "VLP-16", "--duration-s", "5", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto all = nlohmann::json::parse(result.out);
  ASSERT_EQ(all["sensors"].size(), 1u);
  const auto& sensor = all["sensors"][0];
  EXPECT_EQ(sensor["sensor"], "VLP-16");
  const double rays = 16 * named_model("VLP-16").columns;
  EXPECT_EQ(sensor["rays"], rays);
  EXPECT_EQ(sensor["scans"], 50 - 33);
  std::map<std::string, nlohmann::json> rows;
  for (const auto& row : sensor["rows"]) rows[row["name"]] = row;
  for (const char* name : {"compensation", "backward", "box filter", "region growth", "detection", "odometry",
                           "pipeline", "on two threads", "objects", "yardstick"}) {
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
  EXPECT_LT(rows["backward"]["median_ms"], rows["detection"]["median_ms"]);
  EXPECT_LT(rows["odometry"]["median_ms"], rows["pipeline"]["median_ms"]);
  ASSERT_EQ(sensor["threads"].size(), 2u);
  EXPECT_EQ(sensor["threads"][0]["side_by_side"], false);
  EXPECT_EQ(sensor["threads"][1]["threads"], 2);
  EXPECT_EQ(sensor["threads"][1]["median_ms"], rows["on two threads"]["median_ms"]);
}

TEST(BenchmarkSpeed, ADriveTooShortIsRefused) {
  const CommandResult result = run_command({"benchmark", "--speed", "--duration-s", "3"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--duration-s"));
  EXPECT_THAT(result.err, HasSubstr("too short"));
}

TEST(BenchmarkSpeed, WithoutItAnOutputIsRequired) {
  const CommandResult result = run_command({"benchmark", "--quick"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--output"));
}

}  // namespace
}  // namespace mapless
