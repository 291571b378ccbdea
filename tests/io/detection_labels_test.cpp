#include <memory>

#include <gtest/gtest.h>

#include <mapless/io/detection_labels.hpp>

namespace mapless {
namespace {

// Five records, of which 4, 1 and 2 are returns, in that order.
Detection detection_of_three_returns() {
  auto scan = std::make_shared<LidarScan>();
  scan->input_size = 5;
  for (const std::uint32_t index : {4u, 1u, 2u}) scan->returns.push_back({{1, 0, 0}, 1, 0, 0, 0, index});
  Detection detection;
  detection.scan = scan;
  detection.object = {7, 0, 0};
  detection.trace.resize(3);
  detection.trace[0] = {ComparisonVerdict::dynamic, FreespaceVerdict::outside, FreespaceVerdict::inside,
                        BoxVerdict::kept, GrowthVerdict::seed};
  detection.trace[1] = {ComparisonVerdict::dynamic, FreespaceVerdict::inside, FreespaceVerdict::not_asked,
                        BoxVerdict::removed, GrowthVerdict::not_reached};
  return detection;
}

TEST(LabelsOf, HasOneLabelPerRecordInInputOrder) {
  EXPECT_EQ(labels_of(detection_of_three_returns()),
            (std::vector<std::uint32_t>{0, 9, 9, 0, 251u | 7u << 16}));
}

TEST(StageMasksOf, SetsABitPerStageAfterWhichThePointIsDynamic) {
  // Record 4: dynamic, hidden backward, free forward, kept, seed. Record 1: dynamic, free backward, removed.
  EXPECT_EQ(stage_masks_of(detection_of_three_returns()),
            (std::vector<std::uint8_t>{0, 0b00111, 0, 0, 0b11101}));
}

}  // namespace
}  // namespace mapless
