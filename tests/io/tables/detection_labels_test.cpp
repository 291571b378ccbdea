#include <memory>

#include <gtest/gtest.h>

#include <mapless/detection/detection.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// Five records, of which 4, 1 and 2 are returns, in that order.
Detection detection_of_three_returns() {
  auto scan = std::make_shared<LidarScan>();
  scan->input_size = 5;
  for (const std::uint32_t index : {4u, 1u, 2u}) scan->returns.push_back({{1, 0, 0}, 1, 0, 0, 0, index});
  Detection detection;
  detection.scan = scan;
  detection.object = {7, 0, 0};
  detection.trace.resize(3);
  detection.trace[0] = {CandidateVerdict::dynamic, FreespaceVerdict::outside, FreespaceVerdict::inside,
                        FilterVerdict::kept, GrowthVerdict::seed};
  detection.trace[1] = {CandidateVerdict::dynamic, FreespaceVerdict::inside, FreespaceVerdict::not_evaluated,
                        FilterVerdict::removed, GrowthVerdict::not_reached};
  return detection;
}

TEST(LabelsOf, HasOneLabelPerRecordInInputOrder) {
  EXPECT_EQ(labels_of(detection_of_three_returns()),
            (std::vector<std::uint32_t>{0, 9, 9, 0, 251u | 7u << 16}));
}

TEST(LabelsOf, NumbersObjectsByTheirIds) {
  TrackedObject object;
  object.number = 7;
  object.id = 12;
  EXPECT_EQ(labels_of(detection_of_three_returns(), {object}),
            (std::vector<std::uint32_t>{0, 9, 9, 0, 251u | 12u << 16}));
  EXPECT_EQ(label_number(65535), 65535);
  EXPECT_EQ(label_number(65536), 1) << "0 is no object";
}

TEST(ObjectRows, ComeById) {
  TrackedObject object;
  object.number = 1;
  object.id = 12;
  object.velocity_covariance_0 = Eigen::Vector3d(4, 9, 16).asDiagonal();
  TrackedObject other = object;
  other.number = 2;
  other.id = 5;
  const auto rows = object_rows(3, {object, other});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].id, 5u);
  EXPECT_EQ(rows[1].scan, 3u);
  EXPECT_EQ(rows[1].velocity_std_0, Eigen::Vector3d(2, 3, 4));
}

TEST(StageMasksOf, SetsABitPerStageAfterWhichThePointIsDynamic) {
  // Record 4: dynamic, hidden backward, free forward, kept, seed. Record 1: dynamic, free backward, removed.
  EXPECT_EQ(stage_masks_of(detection_of_three_returns()),
            (std::vector<std::uint8_t>{0, 0b00111, 0, 0, 0b11101}));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
