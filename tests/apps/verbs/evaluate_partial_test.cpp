#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::run_command;
using testing::AllOf;
using testing::HasSubstr;

TEST(Evaluate, APartOfAResultOnlyWhereAsked) {
  const test::TemporaryFolder folder;
  const std::string street = folder / "street", out = folder / "out";
  test::write_toy_sequence(test::toy_street("VLP-16"), 4, street);
  ASSERT_EQ(run_command({"detect", street, "-o", out}).exit_code, 0);
  EXPECT_EQ(run_command({"evaluate", street, out}).exit_code, 0);
  const ResultFolder result(out);
  std::filesystem::remove(result.label_file(2));
  const auto lost = run_command({"evaluate", street, out});
  EXPECT_EQ(lost.exit_code, 3);
  EXPECT_THAT(lost.err, AllOf(HasSubstr("scans = 4"), HasSubstr("3 label files"), HasSubstr("--partial")));
  EXPECT_EQ(run_command({"evaluate", street, out, "--partial"}).exit_code, 0);
  std::string ended = read_whole_file(result.summary());
  ended.replace(ended.find("\"complete\": true"), 16, "\"complete\": false");
  write_file_atomically(result.summary(), ended);
  const auto incomplete = run_command({"evaluate", street, out});
  EXPECT_EQ(incomplete.exit_code, 3);
  EXPECT_THAT(incomplete.err, AllOf(HasSubstr("complete = false"), HasSubstr("--partial")));
  write_file_atomically(result.summary(), ended.substr(0, ended.size() / 2));
  const auto damaged = run_command({"evaluate", street, out});
  EXPECT_EQ(damaged.exit_code, 3);
  EXPECT_THAT(damaged.err, AllOf(HasSubstr("summary.json"), HasSubstr("damaged")));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
