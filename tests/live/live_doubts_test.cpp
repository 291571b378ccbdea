#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live/live_robot.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

// A driver that stalls gives its points once more, with a stamp of their own.
TEST(LiveDoubts, CloudsThatContradictEachOtherAreReported) {
  const auto robot = test::driving(12);
  EXPECT_EQ(robot->diagnostics().level, LiveLevel::ok);
  robot->turn(test::cloud_of(test::scans()[11], test::at_ms(1000 + test::kTurnMs * 12)));
  EXPECT_EQ(robot->diagnostics().level, LiveLevel::warning);
  EXPECT_THAT(robot->diagnostics().message, HasSubstr("doubtful scans: scan 12: the same points"));
  robot->drive(13, 16);
  std::size_t said = 0;
  for (const LiveEvent& event : robot->live().take_events())
    said += event.text.starts_with("doubtful") ? 1 : 0;
  EXPECT_EQ(said, 1U);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
