#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::CommandResult;
using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 12;

class DetectObjectsTest : public testing::Test {
 protected:
  DetectObjectsTest() { test::write_toy_sequence(test::toy_street("VLP-16"), kScans, street()); }

  [[nodiscard]] std::string street() const { return folder / "street"; }
  [[nodiscard]] std::string out() const { return folder / "out"; }
  [[nodiscard]] ResultFolder result() const { return ResultFolder(out()); }
  [[nodiscard]] nlohmann::json summary() const {
    return nlohmann::json::parse(read_whole_file(result().summary()));
  }
  [[nodiscard]] CommandResult detect(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"detect", street(), "-o", out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }
  void expect_one_line(const std::string& part) const {
    const CommandResult r = run_command({"evaluate", street(), out()});
    EXPECT_EQ(r.exit_code, 3);
    const std::size_t at = r.err.find("mapless: error: ");
    ASSERT_NE(at, std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin() + static_cast<std::ptrdiff_t>(at), r.err.end(), '\n'), 1) << r.err;
    EXPECT_THAT(r.err, HasSubstr(part));
  }

  test::TemporaryFolder folder;
};

TEST_F(DetectObjectsTest, TellsOfEveryObjectOfEveryScanUnderTheNumberInItsLabels) {
  ASSERT_EQ(detect({"--first", "2"}).exit_code, 0);
  const auto dataset = open_dataset(street());
  std::map<std::pair<std::size_t, std::uint32_t>, int> points;
  for (std::size_t k = 2; k < kScans; ++k) {
    for (const std::uint32_t label : read_label_file(result().label_file(k), dataset->read(k).input_size)) {
      if (label >> 16 != 0) ++points[{k, label >> 16}];
    }
  }
  const std::vector<ObjectRow> rows = read_object_table(result().objects());
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows.size(), points.size());
  std::set<std::uint32_t> ids;
  int oldest = 0;
  for (const ObjectRow& row : rows) {
    SCOPED_TRACE(row.scan);
    EXPECT_EQ(row.points, (points[{row.scan, label_number(row.id)}]));
    EXPECT_GE(row.time, dataset->scan_start(row.scan));
    EXPECT_LE(row.time, dataset->scan_end(row.scan));
    ids.insert(row.id);
    oldest = std::max(oldest, row.age);
  }
  EXPECT_GE(oldest, 4) << "some are followed";
  EXPECT_EQ(summary()["objects"], rows.size());
  EXPECT_EQ(summary()["objects_over_time"], ids.size());
  EXPECT_GE(summary()["timing"]["tracking"]["median_ms"], 0.0);
}

// Truth of the street's velocities, as the simulator would write it.
TEST_F(DetectObjectsTest, VelocitiesAreJudgedAndABrokenTableIsNamed) {
  ASSERT_EQ(detect({}).exit_code, 0);
  const test::ToyScene scene = test::toy_street("VLP-16");
  ObjectStatesWriter states(street() + "/object_states.csv");
  for (std::size_t k = 0; k < kScans; ++k) {
    std::map<std::uint32_t, ObjectState> movers;
    const Time middle = Time::from_seconds(0.1 * static_cast<double>(k) + 0.05);
    for (const test::ToyBody& body : scene.world) {
      const Eigen::Vector3d& v = body.velocity_0;
      if (body.object != 0) movers[body.object] = {middle, body.pose_at(middle).translation(), v, v.norm()};
    }
    states.add(k, movers);
  }
  const CommandResult evaluated = run_command({"evaluate", street(), out(), "--json", folder / "e.json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out,
              testing::AllOf(HasSubstr("velocity of found movers"), HasSubstr("changes of id")));
  const auto velocity = nlohmann::json::parse(read_whole_file(folder / "e.json"))["velocity"];
  EXPECT_GT(velocity["evaluated"], 10);
  EXPECT_LT(velocity["median_mps"], 1);
  fs::resize_file(result().objects(), fs::file_size(result().objects()) - 5);
  expect_one_line("objects.csv:");
  fs::remove(result().objects());
  expect_one_line("objects.csv: cannot be read");
}

TEST_F(DetectObjectsTest, OverwritingBeginsTheTableAnew) {
  ASSERT_EQ(detect({"--count", "10"}).exit_code, 0);
  ASSERT_FALSE(read_object_table(result().objects()).empty());
  ASSERT_EQ(detect({"--count", "1", "--overwrite"}).exit_code, 0);
  EXPECT_TRUE(read_object_table(result().objects()).empty()) << "one scan alone is static";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
