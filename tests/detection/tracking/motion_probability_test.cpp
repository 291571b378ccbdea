#include "detection/tracking/motion_probability.hpp"

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr ObjectMotion kMotions[] = {ObjectMotion::none, ObjectMotion::slow, ObjectMotion::unconfirmed,
                                     ObjectMotion::moving};

TEST(MotionProbability, RisesWithVotesAndStaysBetweenZeroAndOne) {
  for (const ObjectMotion state : kMotions) {
    double last = 0;
    for (int votes = -60; votes <= 60; ++votes) {
      const double p = motion_probability({state, votes, 100});
      EXPECT_GE(p, last) << votes;
      EXPECT_LT(p, 1);
      last = p;
    }
    EXPECT_GT(last, motion_probability({state, -60, 100}));
  }
}

TEST(MotionProbability, RisesWithTheEvidenceOfAMovingObject) {
  EXPECT_LT(motion_probability({ObjectMotion::moving, 4, 50}),
            motion_probability({ObjectMotion::moving, 4, 100}));
  EXPECT_LT(motion_probability({ObjectMotion::moving, 4, 100}),
            motion_probability({ObjectMotion::moving, 4, 1000}));
}

TEST(MotionProbability, IsHighestInMovingObjectsAndLowestOutsideOfObjects) {
  for (int votes = -4; votes <= 16; ++votes) {
    const auto of = [&](ObjectMotion state) { return motion_probability({state, votes, 100}); };
    EXPECT_GT(of(ObjectMotion::moving), of(ObjectMotion::unconfirmed));
    EXPECT_GT(of(ObjectMotion::unconfirmed), of(ObjectMotion::slow));
    EXPECT_GT(of(ObjectMotion::unconfirmed), of(ObjectMotion::none));
  }
}

TEST(MotionProbability, OfAScanIsThatOfEachPoint) {
  std::vector<PointEvidence> votes(4);
  for (std::size_t i = 0; i < votes.size(); ++i) votes[i].past = static_cast<std::int16_t>(8 * i - 12);
  std::vector<TrackMotion> motions(2);
  motions[0].evidence = motions[1].evidence = 300;
  motions[1].moves = true;
  const auto p = motion_probabilities(votes, {0, 1, 2, 0}, motions);
  ASSERT_EQ(p.size(), 4u);
  EXPECT_FLOAT_EQ(p[0], static_cast<float>(motion_probability({ObjectMotion::none, -12, 0})));
  EXPECT_FLOAT_EQ(p[1], static_cast<float>(motion_probability({ObjectMotion::unconfirmed, -4, 300})));
  EXPECT_FLOAT_EQ(p[2], static_cast<float>(motion_probability({ObjectMotion::moving, 4, 300})));
  EXPECT_FLOAT_EQ(p[3], static_cast<float>(motion_probability({ObjectMotion::none, 12, 0})));
}

// The street is not among the scenes to which the weights are fitted. Five cars make no statistics: the sum
// of the probabilities is the expected number of moving points, and has to be theirs to a fifth.
TEST(MotionProbability, SumsToTheNumberOfMovingPoints) {
  const test::ToyScene street = test::toy_street("HDL-64E-S3");
  const auto scans = test::cast_scans(street, 6, 25);
  const auto detections = test::detect_all(test::scans_of(scans), *street.trajectory, {});
  double expected = 0, moving = 0;
  for (std::size_t k = 20; k < detections.size(); ++k) {
    const Detection& d = detections[k];
    ASSERT_EQ(d.probability.size(), d.object.size());
    for (std::size_t i = 0; i < d.object.size(); ++i) {
      expected += static_cast<double>(d.probability[i]);
      const std::uint32_t label = scans[k].labels[d.scan->returns[i].input_index];
      moving += motion_of_label(label) == MotionTruth::moving ? 1 : 0;
    }
  }
  EXPECT_NEAR(expected / moving, 1, 0.2);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
