#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

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
using test::run_command;
using testing::HasSubstr;

struct OutputFile : testing::Test {
  OutputFile() {
    test::write_toy_sequence(test::toy_street("VLP-16"), 2, street);
    ResultFolder result(out);
    result.create(false, "{}");
    const auto dataset = open_dataset(street);
    for (std::size_t k = 0; k < 2; ++k) write_label_file(result.label_file(k), *dataset->read_labels(k));
  }

  // Each verb that writes one file, to `file`.
  std::vector<std::vector<std::string>> commands(const std::string& file) const {
    return {{"view", street, out, "--no-explanations", "-o", file},
            {"render", street, out, "--scan", "0", "-o", file},
            {"export", street, out, "--what", "map", "-o", file},
            {"evaluate", street, out, "--partial", "--json", file}};
  }

  test::TemporaryFolder folder;
  const std::string street = folder / "street", out = folder / "result";
};

TEST_F(OutputFile, IsNoFileOfTheInput) {
  fs::create_directory_symlink(street, folder / "link");
  const std::vector<std::string> files = {street + "/sensor.yaml", street + "/labels/../times.txt",
                                          folder / "link/scans/000000.pcd", out + "/summary.json",
                                          out + "/labels/000000.label"};
  for (const std::string& file : files) {
    const std::string before = read_whole_file(file);
    for (const auto& command : commands(file)) {
      const auto r = run_command(command);
      EXPECT_EQ(r.exit_code, 2) << command[0] << ' ' << file;
      EXPECT_THAT(r.err, HasSubstr("is a file of the re")) << command[0];
      EXPECT_EQ(read_whole_file(file), before) << command[0] << ' ' << file;
    }
  }
}

TEST_F(OutputFile, OfAnEarlierRunIsReplaced) {
  for (int round = 0; round < 2; ++round)
    EXPECT_EQ(run_command(commands(out + "/page.html")[0]).exit_code, 0);
}

// ulimit -f. The system ends who ignores the limit by SIGXFSZ.
TEST_F(OutputFile, BeyondTheLimitOfTheShellIsAnError) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  for (const auto& command : commands(folder / "file")) {
    const rlimit none = {0, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &none);
    const auto r = run_command(command);
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(r.exit_code, 1) << command[0];
    EXPECT_THAT(r.err, HasSubstr("file: cannot be written: File too large")) << command[0];
    EXPECT_FALSE(fs::exists(folder / "file")) << command[0];
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
