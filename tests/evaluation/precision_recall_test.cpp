#include <vector>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Labels = std::vector<std::uint32_t>;
using Mask = std::vector<std::uint8_t>;

TEST(CountPoints, FollowsTheMovingObjectConvention) {
  // truth: unlabelled, outlier, static, road, car, moving car, moving person, moving other with an object
  // number
  const Labels truth = {0, 1, 9, 40, 10, 252, 254, 259u | 7u << 16};
  const Mask all(truth.size(), 1), none(truth.size(), 0);
  EXPECT_EQ(count_points(truth, all), (Counts{.tp = 3, .fp = 3, .fn = 0, .tn = 0}));
  EXPECT_EQ(count_points(truth, none), (Counts{.tp = 0, .fp = 0, .fn = 3, .tn = 3}));
}

TEST(CountPoints, ObjectNumberInTheHighBitsIsNotAClass) {
  EXPECT_EQ(count_points(Labels{9u | 251u << 16, 0u | 251u << 16}, Mask{0, 1}), (Counts{0, 0, 0, 1}));
}

// semantic-kitti-api's iouEval builds conf[prediction, truth], sets the truth column of the ignored class 0
// to zero and takes IoU = TP / (TP + FP + FN). By hand, classes 0 unlabelled, 1 static, 2 moving, rows
// prediction, columns truth:
//     unlabelled [ 1 0 1 ]
//     static     [ 1 4 2 ]
//     moving     [ 2 1 3 ]
// moving: TP 3, FP 1 (the 2 on unlabelled truth are removed), FN 2 + 1, hence 3 / 7.
TEST(CountPoints, AgreesWithTheSemanticKittiDefinition) {
  Labels truth;
  Mask dynamic;
  const auto add = [&](int times, std::uint32_t t, std::uint8_t d) {
    truth.insert(truth.end(), static_cast<std::size_t>(times), t);
    dynamic.insert(dynamic.end(), static_cast<std::size_t>(times), d);
  };
  add(1, 0, 0), add(1, 251, 0);                // predicted unlabelled: not called dynamic
  add(1, 0, 0), add(4, 9, 0), add(2, 251, 0);  // predicted static
  add(2, 0, 1), add(1, 9, 1), add(3, 251, 1);  // predicted moving
  const Counts counts = count_points(truth, dynamic);
  EXPECT_EQ(counts, (Counts{.tp = 3, .fp = 1, .fn = 3, .tn = 4}));
  EXPECT_DOUBLE_EQ(*counts.iou(), 3.0 / 7);
  EXPECT_DOUBLE_EQ(*counts.precision(), 3.0 / 4);
  EXPECT_DOUBLE_EQ(*counts.recall(), 3.0 / 6);
  EXPECT_DOUBLE_EQ(*counts.f1(), 2 * 0.75 * 0.5 / (0.75 + 0.5));
}

TEST(CountPoints, LeavesOutMaskedPoints) {
  EXPECT_EQ(count_points(Labels{251, 251, 9}, Mask{1, 0, 1}, Mask{1, 0, 0}), (Counts{1, 0, 0, 0}));
}

TEST(CountPoints, RefusesVectorsOfAnotherLength) {
  EXPECT_THROW((void)count_points(Labels{9, 9}, Mask{0}), InputError);
  EXPECT_THROW((void)count_points(Labels{9, 9}, Mask{0, 0}, Mask{1}), InputError);
}

TEST(Counts, RatesWithEmptyDenominatorsAreAbsent) {
  const Counts nothing;
  EXPECT_FALSE(nothing.precision() || nothing.recall() || nothing.f1() || nothing.iou());
  const Counts missed{.tp = 0, .fp = 0, .fn = 2, .tn = 0};
  EXPECT_FALSE(missed.precision());
  EXPECT_EQ(missed.recall(), 0.0);
  EXPECT_EQ(missed.f1(), 0.0);
}

TEST(PrecisionRecall, TotalIsOverPointsAndAverageOverScans) {
  PrecisionRecall result;
  result.add({.tp = 9, .fp = 1, .fn = 0, .tn = 5});  // precision 0.9, recall 1
  result.add({.tp = 1, .fp = 1, .fn = 3, .tn = 5});  // precision 0.5, recall 0.25
  result.add({.tp = 0, .fp = 2, .fn = 0, .tn = 5});  // precision 0, no recall
  result.add({.tp = 0, .fp = 0, .fn = 1, .tn = 5});  // no precision, recall 0
  result.add({.tp = 0, .fp = 0, .fn = 0, .tn = 5});  // neither
  EXPECT_EQ(result.scans(), 5);
  EXPECT_EQ(result.precision_scans(), 3);
  EXPECT_EQ(result.recall_scans(), 3);
  EXPECT_DOUBLE_EQ(*result.total().precision(), 10.0 / 14);
  EXPECT_DOUBLE_EQ(*result.total().recall(), 10.0 / 14);
  EXPECT_DOUBLE_EQ(*result.average_precision(), (0.9 + 0.5 + 0.0) / 3);
  EXPECT_DOUBLE_EQ(*result.average_recall(), (1 + 0.25 + 0.0) / 3);
}

TEST(PrecisionRecall, IsAbsentWithoutScans) {
  const PrecisionRecall result;
  EXPECT_FALSE(result.average_precision() || result.average_recall());
  EXPECT_EQ(result.precision_scans(), 0);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
