// Of a build without Embree (MAPLESS_BUILD_SIMULATOR=OFF).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"

namespace mapless {
namespace MAPLESS_FILE {

TEST(NoSimulator, ItsVerbsNameThePackageThatGivesIt) {
  for (const char* verb : {"simulate", "benchmark"}) {
    const test::CommandResult result = test::run_command({verb, "town1", "-o", "out", "--seed", "3"});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, testing::HasSubstr("no simulator"));
    EXPECT_THAT(result.err, testing::HasSubstr("libembree-dev"));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
