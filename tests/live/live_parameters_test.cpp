#include <cmath>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/live/live_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

std::string refusal(const std::function<void(LiveOptions&)>& change) {
  LiveOptions options;
  change(options);
  try {
    const LiveDetector detector(options);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

// 1 to 1000 clouds, 0.1 to 60 s, 0 to 10 s, and at least one reference scan.
TEST(LiveDetector, RefusesParametersOutOfBoundsByName) {
  EXPECT_EQ(refusal([](LiveOptions&) {}), "no error");
  EXPECT_THAT(refusal([](LiveOptions& options) { options.live.queue_clouds = 0; }),
              testing::AllOf(testing::HasSubstr("queue_clouds = 0"), testing::HasSubstr("1000")));
  EXPECT_THAT(refusal([](LiveOptions& options) { options.live.max_gap_s = std::nan(""); }),
              testing::HasSubstr("max_gap_s"));
  EXPECT_THAT(refusal([](LiveOptions& options) { options.live.pose_wait_s = -0.1; }),
              testing::HasSubstr("pose_wait_s"));
  EXPECT_THAT(refusal([](LiveOptions& options) { options.world_frame.clear(); }),
              testing::HasSubstr("world_frame"));
  EXPECT_THAT(refusal([](LiveOptions& options) { options.base_frame = options.world_frame; }),
              testing::HasSubstr("base_frame"));
  EXPECT_THAT(refusal([](LiveOptions& options) { options.detector.detection.voting.references = 0; }),
              testing::HasSubstr("references"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
