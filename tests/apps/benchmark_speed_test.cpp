#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"

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
  EXPECT_EQ(sensor["rays"], 16 * 1800);
  EXPECT_EQ(sensor["scans"], 50 - 33);
  std::set<std::string> names;
  double stages_ms = 0, detection_ms = 0;
  for (const auto& row : sensor["rows"]) {
    const std::string name = row["name"];
    names.insert(name);
    const double median_ms = row["median_ms"];
    EXPECT_GT(median_ms, 0) << name;
    EXPECT_LE(median_ms, row["p95_ms"]) << name;
    EXPECT_LE(row["p95_ms"], row["p99_ms"]) << name;
    EXPECT_NEAR(row["ns_per_ray"], median_ms * 1e6 / (16 * 1800), 1e-6) << name;
    if (name == "detection") detection_ms = median_ms;
    if (name == "yardstick") EXPECT_DOUBLE_EQ(row["yardsticks"], 1);
  }
  EXPECT_EQ(names, (std::set<std::string>{"compensation", "backward", "box filter", "region growth",
                                          "detection", "odometry", "yardstick"}));
  for (const auto& row : sensor["rows"]) {
    if (row["name"] == "detection") EXPECT_DOUBLE_EQ(row["share_of_detection"], 1);
    if (row["name"] == "backward") stages_ms = row["median_ms"];
  }
  EXPECT_LT(stages_ms, detection_ms);
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
