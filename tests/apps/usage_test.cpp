#include <algorithm>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/io/atomic_file.hpp>

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
  expect_error(run_command({"detect", "in", "-o", "out", "--format", "odd"}), 2,
               {"--format", "odd", "native"});
  expect_error(run_command({"detect", "in", "-o", "out", "--pose-frame", "camera"}), 2, {"--trajectory"});
  expect_error(run_command({"detect", "in", "-o", "out", "--stationary", "--trajectory", "x"}), 2,
               {"--stationary"});
}

TEST(Usage, NumbersAreCheckedInPlainWords) {
  expect_error(run_command({"detect", "in", "-o", "out", "--first", "-1"}), 2,
               {"--first: -1", "whole number"});
  expect_error(run_command({"detect", "in", "-o", "out", "--count", "0"}), 2, {"--count: 0", "at least 1"});
  expect_error(run_command({"render", "in", "out", "-o", "x.png", "--scan", "1.5"}), 2,
               {"--scan: 1.5", "whole number"});
  for (const char* range : {"0", "nan", "inf", "near"}) {
    expect_error(run_command({"evaluate", "in", "out", "--max-range", range}), 2,
                 {"--max-range: " + std::string(range), "greater than 0"});
  }
}

TEST(Usage, OutputThatCannotBePrintedIsAnError) {
  const test::TemporaryFolder folder;
  // Short enough to stay in the buffer until the end.
  const std::string command =
      std::string(MAPLESS_COMMAND) + " --version > /dev/full 2> " + (folder / "err").string();
  EXPECT_NE(std::system(command.c_str()), 0);  // NOLINT: a shell redirects
  EXPECT_THAT(read_whole_file(folder / "err"),
              AllOf(StartsWith("mapless: error: standard output"), HasSubstr("No space left")));
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
  expect_error(run_command({"config", "--config", folder / "none.yaml"}), 1, {"none.yaml"});
  expect_error(run_command({"config", "--set", "scan_gap=lots"}), 2, {"--set", "scan_gap", "lots"});
  expect_error(run_command({"config", "--set", "scan_gab=4"}), 2, {"scan_gab", "scan_gap"});
  expect_error(run_command({"config", "--set", "scan_gap"}), 2, {"key=value"});
  expect_error(run_command({"config", "--set", "=4"}), 2, {"key=value"});
  expect_error(run_command({"config", "--set", "normals.window_rows=4"}), 2, {"normals.window_rows", "odd"});
  expect_error(run_command({"config", "--profile", "none"}), 2, {"--profile", "none", "paper"});
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
