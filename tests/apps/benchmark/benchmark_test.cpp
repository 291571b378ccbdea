#include <csignal>
#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::CommandResult;
using test::run_command;
using testing::HasSubstr;
using testing::Not;

constexpr int kScans = 3;
const std::string kRecording = "tunnel_VLP-16_noise0.02_seed1_0.3s";

std::vector<std::string> arguments(const std::string& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = {"benchmark",    "--quick", "--scenes",  "tunnel", "--sensors", "vlp-16",
                                    "--duration-s", "0.3",     "--threads", "2",      "-o",        out};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

nlohmann::json figures(const fs::path& out) {
  return nlohmann::json::parse(read_whole_file(out / "benchmark.json"));
}

// All that is not of the clock.
nlohmann::json lasting(nlohmann::json all) {
  for (const char* key : {"date", "threads"}) all.erase(key);
  for (auto& row : all["rows"]) {
    for (const char* key : {"timing", "threads"}) row["result"].erase(key);
  }
  return all;
}

// One finished benchmark for all tests, which only read it.
class BenchmarkTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    result = run_command(arguments(*shared / "out"));
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT
  void SetUp() override { ASSERT_EQ(result.exit_code, 0) << result.err; }

  [[nodiscard]] static fs::path finished() { return *shared / "out"; }

  static inline test::TemporaryFolder* shared = nullptr;
  static inline CommandResult result;
  test::TemporaryFolder folder;
};

TEST_F(BenchmarkTest, GivesPagePlotsAndFiguresOfEveryRun) {
  const auto all = figures(finished());
  EXPECT_EQ(all["complete"], true);
  std::map<std::string, int> runs;
  for (const auto& row : all["rows"]) {
    ++runs[row["job"]["part"]];
    EXPECT_EQ(row["result"]["final"]["scans"], kScans) << row["job"];
  }
  EXPECT_EQ(runs, (std::map<std::string, int>{{"table", 1}, {"sweep", 5}, {"ablation", 9}}));
  EXPECT_GT(all["rows"][0]["result"]["measures"]["objects"]["of"], 0);
  EXPECT_THAT(result.out, HasSubstr("tunnel"));
  EXPECT_TRUE(fs::is_regular_file(finished() / "plots" / "precision_recall_tunnel.png"));
  EXPECT_EQ(open_dataset(finished() / "recordings" / kRecording)->size(), kScans);
}

// The values of an attribute, but pictures in the page.
std::vector<std::string> values_of(const std::string& page, const std::string& attribute) {
  std::vector<std::string> out;
  for (std::size_t at = page.find(attribute + "=\""); at != std::string::npos;
       at = page.find(attribute + "=\"", at)) {
    at += attribute.size() + 2;
    if (page.compare(at, 5, "data:") != 0) out.push_back(page.substr(at, page.find('"', at) - at));
  }
  return out;
}

TEST_F(BenchmarkTest, ThePageNeedsNothingButItsDriveIn3d) {
  const std::string page = read_whole_file(finished() / "index.html");
  const std::string view = "views/" + kRecording + ".html";
  EXPECT_THAT(values_of(page, "href"), testing::ElementsAre(view));
  EXPECT_THAT(values_of(page, "src"), testing::ElementsAre(view));
  // Not by matchers, which would print the whole page.
  const auto has = [&page](const std::string& text) { return page.find(text) != std::string::npos; };
  EXPECT_TRUE(has("data:image/png;base64,"));
  for (const char* outside : {"<link", "url(", "@import"}) EXPECT_FALSE(has(outside)) << outside;
  for (const char* section : {"Results", "In 3D", "error threshold", "range limit", "stage by stage",
                              "Movers", "By class", "Ablations", "Milliseconds"})
    EXPECT_TRUE(has(section)) << section;
}

TEST_F(BenchmarkTest, ItsDriveIn3dHasTheLabelsThatWereEvaluated) {
  const std::string view = read_whole_file(finished() / "views" / (kRecording + ".html"));
  const std::string begin = R"(<script type="application/json" id="drive">)";
  const std::size_t from = view.find(begin) + begin.size();
  const auto drive = nlohmann::json::parse(view.substr(from, view.find("</script>", from) - from));
  const auto final = figures(finished())["rows"][0]["result"]["final"];
  std::map<std::string, std::int64_t> sums;
  for (const auto& scan : drive["scans"]) {
    for (const char* kind : {"hits", "false", "missed"}) sums[kind] += scan[kind].get<std::int64_t>();
  }
  EXPECT_EQ(drive["scans"].size(), kScans);  // fewer than the view may have
  EXPECT_EQ(sums["hits"], final["tp"]);
  EXPECT_EQ(sums["false"], final["fp"]);
  EXPECT_EQ(sums["missed"], final["fn"]);
}

TEST_F(BenchmarkTest, SameFiguresFromKeptRecordingsOnAnotherNumberOfThreads) {
  const std::string out = folder / "other";
  std::vector<std::string> words = arguments(out, {"--recordings", finished() / "recordings"});
  *(std::find(words.begin(), words.end(), "--threads") + 1) = "1";
  const CommandResult single = run_command(words);
  ASSERT_EQ(single.exit_code, 0) << single.err;
  EXPECT_THAT(single.err, Not(HasSubstr("simulating")));
  EXPECT_EQ(lasting(figures(out)), lasting(figures(finished())));
}

TEST_F(BenchmarkTest, AnInterruptKeepsWhatIsFinishedAndTheNextCallGoesOn) {
  const std::string out = folder / "out";
  test::RunningCommand command(arguments(out, {"--recordings", finished() / "recordings"}));
  ASSERT_TRUE(command.wait_for_error_line("5 of 45 scans"));  // 15 runs of 3
  command.send(SIGINT);
  const CommandResult interrupted = command.wait();
  ASSERT_EQ(interrupted.exit_code, 130) << interrupted.err;
  EXPECT_THAT(interrupted.err, HasSubstr("the same command continues"));
  EXPECT_EQ(figures(out)["complete"], false);
  EXPECT_FALSE(fs::exists(fs::path(out) / "index.html"));

  const CommandResult rest = run_command(arguments(out, {"--recordings", finished() / "recordings"}));
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.err, Not(HasSubstr("15 runs, 0 of them finished before")));
  EXPECT_EQ(lasting(figures(out)), lasting(figures(finished())));
}

TEST_F(BenchmarkTest, AnInterruptedSimulationLeavesNoRecording) {
  const std::string out = folder / "out";
  test::RunningCommand command({"benchmark", "--quick", "--scenes", "flyer", "--sensors", "VLP-16",
                                "--duration-s", "200", "--threads", "1", "-o", out});
  ASSERT_TRUE(command.wait_for_error_line("1 of 2000"));
  command.send(SIGINT);
  EXPECT_EQ(command.wait().exit_code, 130);
  EXPECT_TRUE(fs::is_empty(fs::path(out) / "recordings"));
}

TEST_F(BenchmarkTest, ARunIsUsedAgainOnlyForTheSameParameters) {
  const std::string out = folder / "out";
  fs::copy(finished(), out, fs::copy_options::recursive);
  const CommandResult same = run_command(arguments(out));
  ASSERT_EQ(same.exit_code, 0) << same.err;
  EXPECT_THAT(same.err, HasSubstr("15 runs, 15 of them finished before"));
  fs::remove(fs::path(out) / "rows" / (kRecording + ".sweep.0.1_m.json"));
  write_file_atomically(fs::path(out) / "rows" / (kRecording + ".sweep.0.2_m.json"), "{\"result\": {}");
  EXPECT_THAT(run_command(arguments(out)).err, HasSubstr("15 runs, 13 of them finished before"));
  const CommandResult other = run_command(arguments(out, {"--set", "scan_gap=2"}));
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.err, HasSubstr("15 runs, 1 of them finished before")) << "the paper's profile";
}

TEST_F(BenchmarkTest, ARunWhoseFiguresWereDamagedIsRunAgain) {
  const fs::path out = folder / "out";
  fs::copy(finished(), out, fs::copy_options::recursive);
  const fs::path file = out / "rows" / (kRecording + ".table.true_poses.json");
  auto row = nlohmann::ordered_json::parse(read_whole_file(file));
  ASSERT_TRUE(row["result"].contains("measures"));
  row["result"].erase("measures");
  write_file_atomically(file, row.dump(2));
  const CommandResult again = run_command(arguments(out));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("15 runs, 14 of them finished before"));
  EXPECT_EQ(lasting(figures(out)), lasting(figures(finished())));
}

TEST_F(BenchmarkTest, ARecordingTheSimulatorWouldMakeOtherwiseIsMadeAgain) {
  const std::string out = folder / "out";
  fs::copy(finished(), out, fs::copy_options::recursive);
  fs::remove_all(fs::path(out) / "rows");
  const fs::path manifest = fs::path(out) / "recordings" / kRecording / "manifest.json";
  auto text = nlohmann::ordered_json::parse(read_whole_file(manifest));
  text["digest"] = "0123456789abcdef";
  write_file_atomically(manifest, text.dump(2) + "\n");
  const CommandResult again = run_command(arguments(out));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("simulating 1 recordings (0 made before)"));
  EXPECT_EQ(lasting(figures(out)), lasting(figures(finished())));
}

TEST_F(BenchmarkTest, OwnOdometryStandsBesideTheTruePoses) {
  const std::string out = folder / "out";
  const CommandResult r =
      run_command(arguments(out, {"--recordings", finished() / "recordings", "--odometry"}));
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto rows = figures(out)["rows"];
  EXPECT_EQ(rows[0]["job"]["poses"], "true");
  EXPECT_EQ(rows[1]["job"]["poses"], "own odometry");
  EXPECT_EQ(rows[1]["result"]["final"]["scans"], kScans);
  EXPECT_NE(read_whole_file(fs::path(out) / "index.html").find("IoU, own odometry"), std::string::npos);
}

void expect_refused(const std::vector<std::string>& words, int exit_code, const std::string& part) {
  const CommandResult r = run_command(words);
  EXPECT_EQ(r.exit_code, exit_code) << r.err;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  EXPECT_THAT(r.err, HasSubstr(part));
}

TEST(Benchmark, WrongUseIsOneLineAndLeavesNothingBehind) {
  const test::TemporaryFolder folder;
  const std::string out = folder / "out";
  expect_refused({"benchmark"}, 2, "--output");
  expect_refused({"benchmark", "-o", out, "--scenes", "nowhere"}, 2, "nowhere");
  expect_refused({"benchmark", "-o", out, "--sensors", "HDL-65"}, 2, "HDL-65");
  expect_refused({"benchmark", "-o", out, "--noise", "-0.1"}, 2, "--noise");
  expect_refused({"benchmark", "-o", out, "--noise", "nan"}, 2, "--noise");
  expect_refused({"benchmark", "-o", out, "--seeds", "-1"}, 2, "--seeds");
  expect_refused({"benchmark", "-o", out, "--duration-s", "0.01"}, 2, "--duration-s");
  expect_refused({"benchmark", "-o", out, "--duration-s", "6000"}, 2, "--duration-s");
  expect_refused({"benchmark", "-o", out, "--set", "scan_gap=0"}, 2, "scan_gap");
  expect_refused({"benchmark", "-o", out, "--profile", "best"}, 2, "best");
  EXPECT_FALSE(fs::exists(out));
}

TEST(Benchmark, LeavesFoldersOfOthersAlone) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "photos");
  write_file_atomically(folder / "photos" / "cat.png", "cat");
  expect_refused({"benchmark", "--quick", "-o", folder / "photos"}, 1, "files that are not of a benchmark");
  expect_refused({"benchmark", "--quick", "-o", folder / "photos" / "cat.png"}, 1, "not a folder");
  expect_refused({"benchmark", "--quick", "-o", "/proc/benchmark"}, 1, "/proc/benchmark");
  EXPECT_EQ(read_whole_file(folder / "photos" / "cat.png"), "cat");

  const fs::path recordings = folder / "recordings";
  fs::create_directories(recordings / kRecording / "scans");
  const CommandResult r = run_command(arguments(folder / "out", {"--recordings", recordings}));
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, HasSubstr("no recording of the benchmark"));
  EXPECT_TRUE(fs::exists(recordings / kRecording / "scans"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
