#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/live/live_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

std::string refusal(const LiveOptions& options) {
  try {
    const LiveDetector detector(options);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

// 1 to 1000 clouds, 0.1 to 60 s, 0 to 10 s, and at least one reference scan.
TEST(LiveDetector, RefusesParametersOutOfBoundsByName) {
  LiveOptions options;
  EXPECT_EQ(refusal(options), "no error");
  options.live.queue_clouds = 0;
  EXPECT_THAT(refusal(options),
              testing::AllOf(testing::HasSubstr("queue_clouds = 0"), testing::HasSubstr("1000")));
  options = {};
  options.live.max_gap_s = std::nan("");
  EXPECT_THAT(refusal(options), testing::HasSubstr("max_gap_s"));
  options = {};
  options.live.pose_wait_s = -0.1;
  EXPECT_THAT(refusal(options), testing::HasSubstr("pose_wait_s"));
  options = {};
  options.detector.detection.voting.references = 0;
  EXPECT_THAT(refusal(options), testing::HasSubstr("references"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
