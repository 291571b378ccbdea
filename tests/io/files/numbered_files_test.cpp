#include "io/files/numbered_files.hpp"

#include <filesystem>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::write_text;

TEST(NumberedFiles, FindsFilesByNumberAndIgnoresOthers) {
  const TemporaryFolder folder;
  for (const char* name :
       {"0000000012.bin", "000002.bin", "a.bin", "3.txt", "-1.bin", "1x.bin", "000000.bin"}) {
    write_text(folder / name, "");
  }
  const auto files = numbered_files(folder.path(), ".bin");
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files.at(0), folder / "000000.bin");
  EXPECT_EQ(files.at(12), folder / "0000000012.bin");
  EXPECT_EQ(missing_numbers(files), "1, 3 to 11");
}

// Nobody writes to it: reading it would wait without end.
TEST(NumberedFiles, RefusesAPipe) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink(folder / "nowhere", folder / "1.bin");
  EXPECT_EQ(numbered_files(folder.path(), ".bin").size(), 1U);
  ASSERT_EQ(mkfifo((folder / "2.bin").c_str(), 0600), 0);
  EXPECT_THROW((void)numbered_files(folder.path(), ".bin"), InputError);
}

TEST(NumberedFiles, RefusesDuplicateNumbersAndMissingFolders) {
  const TemporaryFolder folder;
  write_text(folder / "1.bin", "");
  write_text(folder / "01.bin", "");
  EXPECT_THROW((void)numbered_files(folder.path(), ".bin"), InputError);
  EXPECT_THROW((void)numbered_files(folder / "none", ".bin"), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
