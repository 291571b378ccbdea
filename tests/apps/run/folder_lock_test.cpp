#include "run/folder_lock.hpp"

#include <filesystem>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

TEST(FolderLock, TheSecondIsRefusedByNameAndProcess) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "deep/out";
  std::optional<app::FolderLock> first;
  first.emplace(out, "mapless detect");
  try {
    const app::FolderLock second(out, "mapless detect");
    ADD_FAILURE() << "locked twice";
  } catch (const TemporaryError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(out.string()), HasSubstr("in use by mapless detect"),
                                    HasSubstr("process " + std::to_string(getpid()))));
  }
  for (const char* verb : {"detect", "odometry"}) {
    const auto run = test::run_command({verb, folder / "none", "-o", out.string()});
    EXPECT_EQ(run.exit_code, 75) << run.err;
    EXPECT_THAT(run.err, HasSubstr("in use by mapless detect"));
  }
  first.reset();
  EXPECT_FALSE(fs::exists(folder / "deep")) << "nothing was written into it";
}

TEST(FolderLock, AFolderWithContentIsKeptAndTheFileOfAKilledRunLocksNothing) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "out");
  write_file_atomically(folder / "out/.lock", "mapless detect, process 1\n");
  write_file_atomically(folder / "out/mine", "x");
  { const app::FolderLock lock(folder / "out", "mapless detect"); }
  EXPECT_FALSE(fs::exists(folder / "out/.lock"));
  EXPECT_EQ(read_whole_file(folder / "out/mine"), "x");
}

TEST(FolderLock, APathThatIsNoFolderIsNamed) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "file", "x");
  EXPECT_THROW(app::FolderLock(folder / "file", "mapless detect"), OutputError);
  EXPECT_THROW(app::FolderLock(folder / "file/out", "mapless detect"), OutputError);
  EXPECT_EQ(read_whole_file(folder / "file"), "x");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
