#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::CommandResult;
using test::run_command;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kScans = 14;

// The results of one street along given poses ("given") and along own odometry ("own"), each by one run.
class ResumeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::write_toy_sequence(with_columns(test::toy_street("VLP-16"), 600), kScans, street());
    for (const std::string motion : {"given", "own"})
      ASSERT_EQ(run_command(arguments(motion, *shared / motion)).exit_code, 0);
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  [[nodiscard]] static std::string street() { return *shared / "street"; }
  static std::vector<std::string> arguments(const std::string& motion, const std::string& output,
                                            const std::vector<std::string>& more = {}) {
    std::vector<std::string> out = {"detect", street(), "-o", output};
    if (motion == "own") out.emplace_back("--odometry");
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  [[nodiscard]] CommandResult resume(const std::string& motion,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {"--resume"};
    all.insert(all.end(), more.begin(), more.end());
    return run_command(arguments(motion, folder / "out", all));
  }
  // Ends a run by `signal` once it says that `scans` are finished.
  void end_run(const std::string& motion, int signal, int scans, const std::string& option) const {
    test::RunningCommand command(arguments(motion, folder / "out", {option}));
    command.wait_for_error_line(std::to_string(scans) + " of " + std::to_string(kScans) + " scans");
    command.send(signal);
    (void)command.wait();
  }
  // All files but those with times.
  static std::vector<std::string> files_in(const fs::path& root) {
    std::vector<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.is_regular_file() && entry.path().filename() != "summary.json")
        files.push_back(fs::relative(entry.path(), root));
    }
    std::sort(files.begin(), files.end());
    return files;
  }
  void expect_same_bytes_as(const std::string& motion) const {
    EXPECT_EQ(files_in(folder / "out"), files_in(*shared / motion));
    for (const std::string& file : files_in(*shared / motion)) {
      EXPECT_EQ(read_whole_file(fs::path(folder / "out") / file),
                read_whole_file(fs::path(*shared / motion) / file))
          << file;
    }
  }
  // The result of one run as if it had been killed after `scans` scans, within the next.
  void make_killed_result(const std::string& motion, std::size_t scans) const {
    fs::remove_all(folder / "out");
    fs::copy(*shared / motion, folder / "out", fs::copy_options::recursive);
    const ResultFolder result(folder / "out");
    for (std::size_t k = scans; k < kScans; ++k) {
      fs::remove(result.label_file(k));
      if (k > scans) fs::remove(result.stage_file(k));
    }
    write_file_atomically(result.labels() / ".000009.label.partial-1-1", "ha");
    std::string summary = read_whole_file(result.summary());
    summary.replace(summary.find("\"complete\": true"), 16, "\"complete\": false");
    write_file_atomically(result.summary(), summary);
  }

  static inline test::TemporaryFolder* shared = nullptr;
  test::TemporaryFolder folder;
};

TEST_F(ResumeTest, AfterAKillAtAnyInstantTheResultIsThatOfOneRun) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const std::string motion : {"given", "own"}) {
    for (const int signal : {SIGKILL, SIGINT}) {
      fs::remove_all(folder / "out");
      end_run(motion, signal, 1 + static_cast<int>(random() % 6), "--overwrite");
      end_run(motion, signal, 4 + static_cast<int>(random() % 9), "--resume");
      const std::size_t labels = ResultFolder(folder / "out").labelled_scans().size();
      const std::string poses = read_whole_file(ResultFolder(folder / "out").kitti_poses());
      EXPECT_LE(labels, static_cast<std::size_t>(std::count(poses.begin(), poses.end(), '\n')));
      const CommandResult r = resume(motion);
      EXPECT_EQ(r.exit_code, 0) << r.err;
      expect_same_bytes_as(motion);
    }
  }
}

TEST_F(ResumeTest, GoesOnAfterEveryNumberOfFinishedScans) {
  for (const std::size_t scans : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{kScans}}) {
    make_killed_result("given", scans);
    const CommandResult r = resume("given");
    EXPECT_EQ(r.exit_code, 0) << r.err;
    const std::string said =
        scans == 0 ? "starts with the first" : std::to_string(scans) + " scans are finished";
    EXPECT_THAT(r.err, HasSubstr(said));
    expect_same_bytes_as("given");
  }
}

TEST_F(ResumeTest, StartsWithTheFirstScanOfANewFolderAndLeavesACompleteOne) {
  EXPECT_EQ(resume("given").exit_code, 0);
  expect_same_bytes_as("given");
  const CommandResult r = resume("given");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_THAT(r.err, HasSubstr("is complete"));
}

// Own odometry of three scans has not begun: 4, also where --resume finds the result complete.
TEST_F(ResumeTest, DoubtsOfACompleteResultAreSaidAgain) {
  for (const std::string finished : {"", "is complete"}) {
    const CommandResult r = resume("own", {"--count", "3"});
    EXPECT_EQ(r.exit_code, 4) << r.err;
    EXPECT_THAT(r.err, AllOf(HasSubstr(finished), HasSubstr("not certain in any of the 3 scans")));
  }
}

TEST_F(ResumeTest, IsRefusedWhereTheRunWouldDifferAndNamesWhat) {
  make_killed_result("given", 5);
  const auto refusal = [&](const std::string& motion, const std::vector<std::string>& more) {
    const CommandResult r = resume(motion, more);
    EXPECT_EQ(r.exit_code, 2) << r.err;
    return r.err;
  };
  EXPECT_THAT(refusal("own", {}), HasSubstr("trajectory"));
  EXPECT_THAT(refusal("given", {"--count", "9"}), HasSubstr("selected_scans"));
  EXPECT_THAT(refusal("given", {"--causal"}), AllOf(HasSubstr("parameters"), HasSubstr("forward_gap")));
  EXPECT_THAT(refusal("given", {"--overwrite"}), HasSubstr("--overwrite"));
  EXPECT_THAT(refusal("given", {"--probability"}), HasSubstr("probability"));
  const ResultFolder result(folder / "out");
  std::string summary = read_whole_file(result.summary());
  const std::string version = "\"version\": \"";
  summary.insert(summary.find(version) + version.size(), "9");
  write_file_atomically(result.summary(), summary);
  EXPECT_THAT(refusal("given", {}), HasSubstr("version"));
}

TEST_F(ResumeTest, IsRefusedForAnotherRecordingAndAChangedResult) {
  make_killed_result("given", 5);
  std::string labels = read_whole_file(ResultFolder(folder / "out").label_file(3));
  labels[100] ^= 4;
  write_file_atomically(ResultFolder(folder / "out").label_file(3), labels);
  const CommandResult changed = resume("given");
  EXPECT_EQ(changed.exit_code, 3);
  EXPECT_THAT(changed.err, AllOf(HasSubstr("000003.label"), HasSubstr("differs")));
  EXPECT_EQ(ResultFolder(folder / "out").labelled_scans().size(), 5u);  // nothing is touched

  test::write_toy_sequence(with_columns(test::toy_street("VLP-16"), 599), kScans, folder / "other");
  const CommandResult other = run_command({"detect", folder / "other", "-o", folder / "out", "--resume"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("recording_digest"));

  make_killed_result("own", 5);
  const CommandResult measured = resume("own", {"--initial-velocity", "3,0,0"});
  EXPECT_EQ(measured.exit_code, 2);
  EXPECT_THAT(measured.err, HasSubstr("recording_digest"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
