#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "support/command.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::CommandResult;
using test::run_command;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

// Errors are one line that says so.
void expect_error(const CommandResult& result, int exit_code, const std::vector<std::string>& parts) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_THAT(result.err, StartsWith("mapless: error: "));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& part : parts) EXPECT_THAT(result.err, HasSubstr(part));
  EXPECT_THAT(result.out, IsEmpty());
}

TEST(Usage, HelpNamesEveryVerb) {
  const CommandResult result = run_command({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* verb : {"detect", "evaluate", "info", "render", "simulate", "benchmark", "config"}) {
    EXPECT_THAT(result.out, HasSubstr(verb));
    EXPECT_EQ(run_command({verb, "--help"}).exit_code, 0);
  }
}

TEST(Usage, VersionIsPrinted) {
  const CommandResult result = run_command({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::MatchesRegex("mapless [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Usage, WrongUseIsNamedInOneLine) {
  expect_error(run_command({}), 2, {"--help"});
  expect_error(run_command({"frobnicate"}), 2, {"frobnicate"});
  expect_error(run_command({"config", "--frobnicate"}), 2, {"--frobnicate"});
  expect_error(run_command({"detect"}), 2, {"IN"});
  expect_error(run_command({"detect", "in", "-o", "out", "--threads", "0"}), 2, {"--threads"});
  expect_error(run_command({"detect", "in", "-o", "out", "--sensor", ""}), 2, {"--sensor", "empty"});
  expect_error(run_command({"view", "in", "-o", "out", "--scans", ""}), 2, {"--scans", "empty"});
  expect_error(run_command({"detect", "in", "-o", "out", "--trajectory", ""}), 2, {"--trajectory", "empty"});
  expect_error(run_command({"detect", "in", "-o", "out", "--format", "odd"}), 2,
               {"--format", "odd", "native"});
  expect_error(run_command({"detect", "in", "-o", "out", "--pose-frame", "camera"}), 2, {"--trajectory"});
  expect_error(run_command({"detect", "in", "-o", "out", "--stationary", "--trajectory", "x"}), 2,
               {"--stationary"});
}

TEST(Usage, NamesOfOutputsHaveNoControlCharacters) {
  for (const std::string verb : {"detect", "odometry", "render", "view", "export"})
    expect_error(run_command({verb, "in", "-o", "a\nb"}), 2, {"--output", "line break"});
  expect_error(run_command({"simulate", "town1", "-o", "a\nb"}), 2, {"--output", "line break"});
  expect_error(run_command({"simulate", "town1", "-o", ""}), 2, {"--output", "empty"});
}

TEST(Usage, LongWordsAreNotEchoedWhole) {
  const std::string word(5000, 'w');
  for (const auto& arguments : {std::vector<std::string>{"info", word}, {"frobnicate" + word}}) {
    const auto r = run_command(arguments);
    EXPECT_NE(r.exit_code, 0);
    EXPECT_LT(r.err.size(), 1000u);
  }
}

TEST(Usage, NumbersAreCheckedInPlainWords) {
  const test::TemporaryFolder folder;
  expect_error(run_command({"detect", "in", "-o", "out", "--first", "-1"}), 2,
               {"--first: -1", "whole number"});
  expect_error(run_command({"detect", "in", "-o", "out", "--count", "0"}), 2, {"--count: 0", "at least 1"});
  expect_error(run_command({"render", "in", "out", "-o", "x.png", "--scan", "1.5"}), 2,
               {"--scan: 1.5", "whole number"});
  for (const char* seed : {"-1", "99999999999999999999", "0x10"}) {
    expect_error(run_command({"simulate", "town1", "-o", "out", "--seed", seed}), 2,
                 {"--seed: " + std::string(seed), "whole number"});
  }
  expect_error(run_command({"simulate", "town1", "-o", "out", "--range-noise-m", "nan"}), 2,
               {"--range-noise-m: nan", "from 0 to 1"});
  expect_error(run_command({"simulate", "town1", "-o", "out", "--duration-s", "nan"}), 2,
               {"--duration-s: nan", "greater than 0"});
  const CommandResult longer =
      run_command({"simulate", "town1", "-o", folder / "out", "--duration-s", "1e300"});
  EXPECT_EQ(longer.exit_code, 2) << longer.err;
  EXPECT_THAT(longer.err, HasSubstr("duration = 1e+300 s: not above 0 and at most 600 s"));
  expect_error(run_command({"render", "in", "-o", "x.png", "--scan", "0", "--extent-m", "nan"}), 2,
               {"--extent-m: nan", "from 1 to 1000"});
  for (const char* range : {"0", "nan", "inf", "near"}) {
    expect_error(run_command({"evaluate", "in", "out", "--max-range", range}), 2,
                 {"--max-range: " + std::string(range), "greater than 0"});
  }
}

TEST(Usage, OutputThatCannotBePrintedIsAnError) {
  const test::TemporaryFolder folder;
  // Short enough to stay in the buffer until the end.
  const std::string command =
      test::built_command() + " --version > /dev/full 2> " + (folder / "err").string();
  EXPECT_NE(std::system(command.c_str()), 0);  // NOLINT: a shell redirects
  EXPECT_THAT(read_whole_file(folder / "err"),
              AllOf(StartsWith("mapless: error: standard output"), HasSubstr("No space left")));
}

// Through a shell that redirects; its exit code.
int run_in_shell(const std::string& arguments_and_redirections) {
  const int status =
      std::system((test::built_command() + " " + arguments_and_redirections).c_str());  // NOLINT
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Usage, LongOutputThatCannotBePrintedIsTheSameError) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(run_in_shell("config > /dev/full 2> " + (folder / "err").string()), 75);
  EXPECT_THAT(read_whole_file(folder / "err"),
              AllOf(StartsWith("mapless: error: standard output"), HasSubstr("No space left")));
}

TEST(Usage, WorkGoesOnWhereNothingCanBeSaid) {
  const test::TemporaryFolder folder;
  const std::string make = "simulate crossing --sensor VLP-16 --duration-s 0.1 -o ";
  EXPECT_EQ(run_in_shell(make + (folder / "full").string() + " 2> /dev/full > /dev/null"), 0);
  EXPECT_EQ(run_in_shell(make + (folder / "closed").string() + " 2>&- > /dev/null"), 0);
  EXPECT_EQ(read_whole_file(folder / "full/scans/000000.pcd"),
            read_whole_file(folder / "closed/scans/000000.pcd"));
  EXPECT_EQ(run_in_shell("frobnicate 2>&-"), 2);
  EXPECT_EQ(run_in_shell("config >&- 2> /dev/null"), 1);
}

TEST(Usage, PathsTheSystemRefusesAreNamed) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  const std::string loop = folder / "loop";
  expect_error(run_command({"simulate", "town1", "-o", loop}), 1, {loop + ": cannot be accessed", ";"});
  expect_error(run_command({"odometry", "in", "-o", loop}), 1, {loop, "symbolic links", ";"});
}

TEST(Config, PrintsEveryParameterWithItsUnit) {
  const CommandResult result = run_command({"config"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  DetectorParameters defaults;
  for (const ParameterReference& p : parameter_references(defaults)) {
    EXPECT_THAT(result.out, HasSubstr(p.key.substr(p.key.rfind('.') + 1) + ": " + p.text() + "\n"));
    EXPECT_THAT(result.out, HasSubstr(std::string(p.source)));
  }
}

TEST(Config, ReadsWhatItPrints) {
  const test::TemporaryFolder folder;
  const CommandResult paper =
      run_command({"config", "--profile", "paper", "--set", "freespace.border_window_rows=5"});
  EXPECT_EQ(paper.exit_code, 0) << paper.err;
  write_file_atomically(folder / "paper.yaml", paper.out);
  const CommandResult read = run_command({"config", "--config", folder / "paper.yaml"});
  EXPECT_EQ(read.exit_code, 0) << read.err;
  EXPECT_EQ(read.out, paper.out);
}

TEST(Config, SchemaHasBoundsAndUnits) {
  const CommandResult result = run_command({"config", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("\"error_threshold_m\": {"), HasSubstr("\"unit\": \"m\""),
                                HasSubstr("\"additionalProperties\": false")));
  const auto schema = nlohmann::json::parse(result.out);
  EXPECT_EQ(schema["properties"]["normals"]["properties"]["window_rows"]["not"]["multipleOf"], 2);
}

TEST(Config, NamesWhatItRefuses) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "bad.yaml", "scan_gap: 4\nfreespace:\n  no_such_key: 1\n");
  expect_error(run_command({"config", "--config", folder / "bad.yaml"}), 2,
               {folder / "bad.yaml", ":3", "freespace.no_such_key"});
  write_file_atomically(folder / "bad.yaml", "scan_gap: 1000\n");
  expect_error(run_command({"config", "--config", folder / "bad.yaml"}), 2,
               {":1", "scan_gap", "1000", "100"});
  expect_error(run_command({"config", "--config", folder / "none.yaml"}), 3, {"none.yaml"});
  expect_error(run_command({"config", "--set", "scan_gap=lots"}), 2, {"--set", "scan_gap", "lots"});
  expect_error(run_command({"config", "--set", "scan_gab=4"}), 2, {"scan_gab", "scan_gap"});
  expect_error(run_command({"config", "--set", "scan_gap"}), 2, {"key=value"});
  expect_error(run_command({"config", "--set", "=4"}), 2, {"key=value"});
  expect_error(run_command({"config", "--set", "normals.window_rows=4"}), 2, {"normals.window_rows", "odd"});
  expect_error(run_command({"config", "--profile", "none"}), 2,
               {"--profile", "none", "paper", "paper-literal"});
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
