// Of a build without Cyclone DDS (MAPLESS_BUILD_LIVE=OFF), and of the Python package.
#include <array>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "verbs/command.hpp"

namespace mapless {
namespace MAPLESS_FILE {

TEST(NoDds, TheVerbLiveNamesThePackagesThatGiveIt) {
  std::string name = "mapless", verb = "live", option = "--points", topic = "points";
  std::array<char*, 5> arguments = {name.data(), verb.data(), option.data(), topic.data(), nullptr};
  testing::internal::CaptureStderr();
  EXPECT_EQ(app::run_command(4, arguments.data()), 1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(testing::HasSubstr("no DDS"), testing::HasSubstr("cyclonedds-dev")));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
