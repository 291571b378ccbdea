#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include "view/drive_page.hpp"
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::run_command;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The string in the command is the committed file, which the test viewer.page compares with its sources.
TEST(View, HasTheCommittedPage) {
  const std::filesystem::path page = test::test_file("../apps/mapless/view/page.html");
  EXPECT_TRUE(app::page_template() == read_whole_file(page));
}

TEST(View, WritesTheScansAskedForIntoOneFile) {
  const test::TemporaryFolder folder;
  const std::string street = folder / "street", out = folder / "out", html = folder / "drive.html";
  test::write_toy_sequence(test::toy_street("VLP-16"), 6, street);
  ASSERT_EQ(run_command({"detect", street, "-o", out}).exit_code, 0);
  const auto written = run_command({"view", street, out, "-o", html, "--scans", "1:", "--every", "2"});
  EXPECT_EQ(written.exit_code, 0) << written.err;
  EXPECT_THAT(written.out, HasSubstr("3 scans"));
  const std::string page = read_whole_file(html);
  EXPECT_THAT(page,
              AllOf(HasSubstr("id=\"scan-1\""), HasSubstr("id=\"scan-3\""), HasSubstr("id=\"scan-5\"")));
  EXPECT_THAT(page, Not(HasSubstr("id=\"scan-2\"")));
  // The first scan comes before the program, which can then draw it at once.
  EXPECT_LT(page.find("id=\"scan-1\""), page.find("DecompressionStream"));
  EXPECT_GT(page.find("id=\"scan-3\""), page.find("DecompressionStream"));
}

// The explanations read the file first, and the page after them.
TEST(View, ADamagedLabelFileIsSaidOnce) {
  const test::TemporaryFolder folder;
  const std::string street = folder / "street", out = folder / "out", html = folder / "drive.html";
  test::write_toy_sequence(test::toy_street("VLP-16"), 4, street);
  ASSERT_EQ(run_command({"detect", street, "-o", out}).exit_code, 0);
  write_file_atomically(out + "/labels/000002.label", "short");
  const auto refused = run_command({"view", street, out, "-o", html});
  EXPECT_EQ(refused.exit_code, 3);
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = refused.err.find("000002.label", at)) != std::string::npos; ++at) ++lines;
  EXPECT_EQ(lines, 1u) << refused.err;
}

TEST(View, RefusesARangeWithoutScans) {
  const test::TemporaryFolder folder;
  const std::string street = folder / "street", html = folder / "drive.html";
  test::write_toy_sequence(test::toy_street("VLP-16"), 2, street);
  for (const std::string range : {"7:9", "3", "b:c", "2:1"}) {
    const auto refused = run_command({"view", street, "-o", html, "--scans", range});
    EXPECT_EQ(refused.exit_code, 2) << range;  // wrong usage
    EXPECT_THAT(refused.err, AllOf(HasSubstr("--scans"), HasSubstr(range)));
  }
  EXPECT_FALSE(std::filesystem::exists(html));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
