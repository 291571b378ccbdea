#include "terminal/exit_codes.hpp"

#include <filesystem>
#include <new>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

TEST(ExitCodes, EveryKindOfErrorHasItsCode) {
  const ErrorDetail detail;
  EXPECT_EQ(app::exit_code_of(std::bad_alloc()), 1);
  EXPECT_EQ(app::exit_code_of(Error(detail)), 1);
  EXPECT_EQ(app::exit_code_of(OutputError(detail)), 1);
  EXPECT_EQ(app::exit_code_of(AccessError(detail)), 1);
  EXPECT_EQ(app::exit_code_of(ParameterError(detail)), 2);
  EXPECT_EQ(app::exit_code_of(InputError(detail)), 3);
  EXPECT_EQ(app::exit_code_of(TrajectoryDomainError(detail)), 3);
  EXPECT_EQ(app::exit_code_of(TemporaryError(detail)), 75);
}

TEST(ExitCodes, AFullDiskIsWorthAnotherTryAndAMissingFileIsNot) {
  EXPECT_THROW(append_to_file("/dev/full", "x"), TemporaryError);
  EXPECT_THROW(throw_write_error({}, std::make_error_code(std::errc::permission_denied)), OutputError);
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  EXPECT_THROW((void)read_whole_file(folder / "loop"), AccessError);
  try {
    (void)read_whole_file(folder / "none");
  } catch (const AccessError&) {
    ADD_FAILURE() << "a file that is not there is a matter of the input";
  } catch (const InputError&) {
  }
}

TEST(ExitCodes, HelpHasTheTable) {
  const std::string help = test::run_command({"--help"}).out;
  for (const char* line : {"  0 ", "  1 ", "  2 ", "  3 ", "  4 ", "  75 ", "  128 + N "})
    EXPECT_THAT(help, HasSubstr(line));
}

TEST(ExitCodes, TheCommandReturnsThem) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  EXPECT_EQ(test::run_command({"config"}).exit_code, 0);
  EXPECT_EQ(test::run_command({"info", folder / "loop"}).exit_code, 1);
  EXPECT_EQ(test::run_command({"info", folder / "none", "--format", "odd"}).exit_code, 2);
  EXPECT_EQ(test::run_command({"info", folder / "none"}).exit_code, 3);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
