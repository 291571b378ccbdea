#include "detection/tracking/motion_classifier.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr float kDisplaced_m = 0.25F, kNotDisplaced_m = 0.24F;  // parameters() requires 0.25
constexpr double kFast_mps = 0.5, kSlow_mps = 0.49;             // and 0.5
constexpr double kWell_mps = 0.1, kBadly_mps = 10;              // known at any speed; known above 20 m/s
constexpr int kVotes = 100;                                     // and 100
constexpr Time kStart = Time::from_seconds(100);

VotingParameters parameters() {
  VotingParameters p;
  p.min_displacement_m = 0.25;
  p.min_speed_mps = 0.5;
  p.min_evidence = kVotes;
  return p;
}

TrackedObject object(double speed_mps, double std_mps) {
  TrackedObject o;
  o.age = 2;
  o.velocity_0 = {0, speed_mps, 0};
  o.velocity_covariance_0 = std_mps * std_mps * Matrix3d::Identity();
  return o;
}

// 0.1 s after a scan at kStart.
TrackMotion next(const TrackMotion& last, const TrackedObject& o, float displacement_m, int votes = kVotes) {
  return MotionClassifier(parameters())
      .update(last, o, {displacement_m, votes}, kStart + Duration::from_seconds(0.1));
}

TrackMotion moving() {
  TrackMotion state;
  state.moves = true;
  state.age = 1;
  state.seen = kStart;
  return state;
}
TrackMotion standing() {
  TrackMotion state = moving();
  state.moves = false;
  state.slow = true;
  return state;
}

bool new_track_moves(float displacement_m, int votes) {
  TrackedObject o = object(0, kBadly_mps);
  o.age = 1;
  return next({}, o, displacement_m, votes).moves;
}

TEST(MotionClassifier, ANewTrackMovesWithDisplacementAndEvidence) {
  EXPECT_TRUE(new_track_moves(kDisplaced_m, kVotes));
  EXPECT_FALSE(new_track_moves(kDisplaced_m, kVotes - 1));
  EXPECT_FALSE(new_track_moves(kNotDisplaced_m, kVotes));
}

// 40 / 2 / 2 + 60 / 2 + 60 = 100, and 99 with one vote less in the last scan. Negative votes of a scan are
// not subtracted from past evidence.
TEST(MotionClassifier, PastEvidenceIsHalvedPerScan) {
  for (const int last_votes : {60, 59}) {
    TrackedObject o = object(kFast_mps, kWell_mps);
    o.age = 1;
    TrackMotion state = next({}, o, kDisplaced_m, 40);
    for (const int votes : {60, last_votes}) {
      EXPECT_FALSE(state.moves);
      ++o.age;
      state = next(state, o, kDisplaced_m, votes);
    }
    EXPECT_DOUBLE_EQ(state.evidence, 40 + last_votes);
    EXPECT_EQ(state.moves, last_votes == 60);
    ++o.age;
    EXPECT_DOUBLE_EQ(next(state, o, kDisplaced_m, -5).evidence, (40 + last_votes) / 2.0);
  }
}

TEST(MotionClassifier, EvidenceIsHalvedForUnseenScansToo) {
  TrackedObject o = object(kFast_mps, kWell_mps);
  o.age = 1;
  const TrackMotion first = next({}, o, kDisplaced_m, 80);
  o.age = 4;
  EXPECT_DOUBLE_EQ(next(first, o, kDisplaced_m, 90).evidence, 100);
}

// Factors 0.25, 1 and 1.5.
TEST(MotionClassifier, RequiredEvidenceDependsOnTheBody) {
  for (const auto& [body, votes] : {std::pair{Body::rigid, kVotes / 4}, std::pair{Body::unclear, kVotes},
                                    std::pair{Body::porous, kVotes * 3 / 2}}) {
    for (const int less : {0, 1}) {
      const ObjectEvidence evidence = {kDisplaced_m, votes - less, body};
      EXPECT_EQ(MotionClassifier(parameters())
                    .update(standing(), object(kFast_mps, kWell_mps), evidence,
                            kStart + Duration::from_seconds(0.1))
                    .moves,
                less == 0);
    }
  }
}

// From its third scan on, a known velocity suffices for a porous body.
TEST(MotionClassifier, APorousBodyWithKnownVelocityNeedsNoMoreEvidence) {
  for (const int age : {2, 3}) {
    TrackedObject o = object(kFast_mps, kWell_mps);
    o.age = age;
    const ObjectEvidence evidence = {kDisplaced_m, kVotes, Body::porous};
    EXPECT_EQ(MotionClassifier(parameters())
                  .update(standing(), o, evidence, kStart + Duration::from_seconds(0.1))
                  .moves,
              age == 3);
  }
}

TEST(MotionClassifier, AMovingTrackWithKnownVelocityNeedsNoEvidence) {
  EXPECT_TRUE(next(moving(), object(kFast_mps, kWell_mps), kDisplaced_m, 0).moves);
}

// A standard deviation of 1 m/s is twice 0.5 m/s: a track begins with twice the evidence and continues with
// half of that.
TEST(MotionClassifier, RequiredEvidenceGrowsWithTheStandardDeviation) {
  TrackedObject o = object(5, 1);
  o.age = 3;
  TrackMotion known = standing();
  known.velocity_known = true;
  known.age = 2;
  EXPECT_FALSE(next(known, o, kDisplaced_m, 2 * kVotes - 1).moves);
  EXPECT_TRUE(next(known, o, kDisplaced_m, 2 * kVotes).moves);
  known.moves = true;
  EXPECT_FALSE(next(known, o, kDisplaced_m, kVotes - 1).moves);
  EXPECT_TRUE(next(known, o, kDisplaced_m, kVotes).moves);
}

// No evidence is needed to continue with a velocity known to 0.5 m/s; in the second scan none is known well
// yet.
TEST(MotionClassifier, AWellKnownVelocityOrAYoungTrackNeedsNoMoreEvidence) {
  TrackMotion known = moving();
  known.velocity_known = true;
  known.age = 2;
  TrackedObject o = object(5, 0.5);
  o.age = 3;
  EXPECT_TRUE(next(known, o, kDisplaced_m, 0).moves);
  EXPECT_TRUE(next(moving(), object(5, 1), kDisplaced_m, 0).moves);
  EXPECT_TRUE(next(standing(), object(5, 1), kDisplaced_m, kVotes).moves);
}

// It may move in its second scan, and later if its velocity was known once.
TEST(MotionClassifier, ATrackOfNeverKnownVelocityIsStaticFromItsThirdScanOn) {
  TrackedObject o = object(0, kBadly_mps);
  const TrackMotion second = next(moving(), o, kDisplaced_m);
  EXPECT_TRUE(second.moves);
  o.age = 3;
  EXPECT_FALSE(next(second, o, kDisplaced_m).moves);
  const TrackMotion known = next(second, object(kFast_mps, kWell_mps), kDisplaced_m);
  EXPECT_TRUE(next(known, o, kDisplaced_m, 10 * kVotes).moves);  // half of what 10 m/s require
}

TEST(MotionClassifier, NegativeVotesStopAYoungTrackOfUnknownVelocity) {
  EXPECT_TRUE(next(moving(), object(0, kBadly_mps), kDisplaced_m, 0).moves);
  EXPECT_FALSE(next(moving(), object(0, kBadly_mps), kDisplaced_m, -1).moves);
  EXPECT_TRUE(next(moving(), object(kFast_mps, kWell_mps), kDisplaced_m, -1).moves);
}

// A standard deviation of 10 m/s requires 20 times the evidence, kSufficientRayEvidence twice that. Past
// evidence is halved.
TEST(MotionClassifier, SufficientRayEvidenceNeedsNoKnownVelocity) {
  TrackedObject o = object(0, kBadly_mps);
  const TrackMotion second = next(moving(), o, kDisplaced_m, 0);
  o.age = 3;
  EXPECT_FALSE(next(second, o, kDisplaced_m, 40 * kVotes - 1).moves);
  const TrackMotion third = next(second, o, kDisplaced_m, 40 * kVotes);
  EXPECT_TRUE(third.moves);
  o.age = 4;
  EXPECT_FALSE(next(third, o, kDisplaced_m, 20 * kVotes - 1).moves);
  EXPECT_TRUE(next(third, o, kDisplaced_m, 20 * kVotes).moves);
}

TEST(MotionClassifier, TheSpeedOfANewTrackIsIgnored) {
  TrackedObject o = object(0, kWell_mps);
  o.age = 1;
  const TrackMotion state = next({}, o, kDisplaced_m);
  EXPECT_TRUE(state.moves);
  EXPECT_FALSE(state.slow);
  o.velocity_0 = {0, 20, 0};
  EXPECT_FALSE(next({}, o, 0).moves);
  EXPECT_EQ(next({}, o, 0).unconfirmed_m, 0);
}

TEST(MotionClassifier, KeepsTheStartOfTheScan) {
  const Time now = Time::from_seconds(7);
  EXPECT_EQ(MotionClassifier(parameters()).update({}, object(0, 1), {}, now).seen, now);
  TrackedObject o = object(0, 1);
  o.age = 1;
  EXPECT_EQ(MotionClassifier(parameters()).update({}, o, {}, now).seen, now);
}

TEST(MotionClassifier, ATrackBeginsToMoveWithSpeedAndDisplacement) {
  EXPECT_TRUE(next(standing(), object(kFast_mps, kWell_mps), kDisplaced_m).moves);
  EXPECT_FALSE(next(standing(), object(kFast_mps, kWell_mps), kNotDisplaced_m).moves);
  EXPECT_FALSE(next(standing(), object(kSlow_mps, kWell_mps), kDisplaced_m).moves);
}

// 0.59 m/s with a standard deviation of 0.3 m/s is within 2 sigma of zero; a moving track continues with it.
TEST(MotionClassifier, ASpeedWithinTwoSigmaOfZeroDoesNotBegin) {
  EXPECT_FALSE(next(standing(), object(0.59, 0.3), kDisplaced_m).moves);
  EXPECT_TRUE(next(standing(), object(0.61, 0.3), kDisplaced_m).moves);
  EXPECT_TRUE(next(moving(), object(0.59, 0.3), kDisplaced_m).moves);
}

// 2 m/s are 0.8 m in four scans of 0.1 s, of which the rays have to show half.
TEST(MotionClassifier, AfterThreeStaticScansTheRaysHaveToConfirmHalfOfTheVelocity) {
  TrackMotion state = standing();
  TrackedObject o = object(2, kWell_mps);
  for (const int static_scans : {2, 3}) {
    state.static_scans = static_scans;
    EXPECT_EQ(next(state, o, 0.39F).moves, static_scans < 3);
    EXPECT_TRUE(next(state, o, 0.41F).moves);
  }
  o.age = 3;  // not seen in the scan between: two scans in 0.1 s
  EXPECT_TRUE(next(state, o, kDisplaced_m).moves);
  EXPECT_FALSE(next(state, object(2, kWell_mps), kDisplaced_m).moves);
}

TEST(MotionClassifier, CountsScansWithAKnownSlowVelocity) {
  TrackMotion state = standing();
  state = next(state, object(kSlow_mps, kWell_mps), kNotDisplaced_m);
  state = next(state, object(kSlow_mps, kWell_mps), kDisplaced_m);
  EXPECT_EQ(state.static_scans, 2);
  state = next(state, object(kFast_mps, kWell_mps), kNotDisplaced_m);
  state = next(state, object(0, kBadly_mps), kNotDisplaced_m);  // slow, but not known
  EXPECT_EQ(state.static_scans, 2);
  state.moves = true;
  EXPECT_EQ(next(state, object(kSlow_mps, kWell_mps), kNotDisplaced_m).static_scans, 0);
}

TEST(MotionClassifier, ATrackOfUnknownVelocityBeginsWithADisplacementAlone) {
  EXPECT_TRUE(next(standing(), object(0, kBadly_mps), kDisplaced_m).moves);
  EXPECT_FALSE(next(standing(), object(19, kBadly_mps), kNotDisplaced_m).moves);
}

// The parts of a parked car that a near sensor sees change: its velocity is found, and lost again.
TEST(MotionClassifier, AVelocityThatWasKnownBeginsNoMotionByGettingLost) {
  TrackMotion was_known = standing();
  was_known.velocity_known = true;
  const TrackedObject lost = object(kFast_mps, kBadly_mps);
  EXPECT_FALSE(next(was_known, lost, kDisplaced_m).moves);
  EXPECT_EQ(next(was_known, lost, kDisplaced_m).reason, TrackReason::may_be_zero);
  EXPECT_TRUE(next(was_known, object(2.1 * kBadly_mps, kBadly_mps), kDisplaced_m).moves);  // beyond 2 sigma
  TrackMotion moved = was_known;
  moved.moves = true;
  EXPECT_TRUE(next(moved, lost, kDisplaced_m).moves);  // goes on
}

TEST(MotionClassifier, AKnownSpeedDecidesWhatIsSlow) {
  for (const float displacement_m : {kDisplaced_m, kNotDisplaced_m}) {
    EXPECT_TRUE(next(moving(), object(kSlow_mps, kWell_mps), displacement_m).slow);
    EXPECT_FALSE(next(moving(), object(kFast_mps, kWell_mps), displacement_m).slow);
  }
}

TEST(MotionClassifier, OfAnUnknownSpeedTheDisplacementDecidesWhatIsSlow) {
  for (const double speed_mps : {0.0, 19.0}) {
    EXPECT_TRUE(next(moving(), object(speed_mps, kBadly_mps), kNotDisplaced_m).slow);
    EXPECT_FALSE(next(moving(), object(speed_mps, kBadly_mps), kDisplaced_m).slow);
  }
}

// Without displacement an unknown speed is slow; 0.99 m/s are less than two sigma in both cases.
TEST(MotionClassifier, ASpeedIsKnownToHalfAMetrePerSecond) {
  EXPECT_FALSE(next(moving(), object(0.99, 0.5), kNotDisplaced_m).slow);
  EXPECT_TRUE(next(moving(), object(0.99, 0.51), kNotDisplaced_m).slow);
}

TEST(MotionClassifier, TheLargestStandardDeviationDecidesWhetherASpeedIsKnown) {
  for (int axis = 0; axis < 3; ++axis) {
    TrackedObject o = object(0.5, 0.26);  // less than two sigma
    EXPECT_FALSE(next(moving(), o, kNotDisplaced_m).slow);
    o.velocity_covariance_0(axis, axis) = 0.51 * 0.51;
    EXPECT_TRUE(next(moving(), o, kNotDisplaced_m).slow) << axis;
  }
}

TEST(MotionClassifier, ASpeedOfMoreThanTwoSigmaIsKnown) {
  EXPECT_TRUE(next(moving(), object(7.9, 4), kNotDisplaced_m).slow);
  EXPECT_FALSE(next(moving(), object(8.1, 4), kNotDisplaced_m).slow);
}

// Across a wall 0.25 m/s are known to 0.1 m/s, along it nothing: the speed is known, and slow.
TEST(MotionClassifier, SigmasAreThoseAlongTheVelocity) {
  TrackedObject wall = object(0.25, 0.1);
  wall.velocity_covariance_0(0, 0) = 100;
  EXPECT_TRUE(next(moving(), wall, kDisplaced_m).slow);
  wall.velocity_0 = {0.25, 0, 0};
  EXPECT_FALSE(next(moving(), wall, kDisplaced_m).slow);
}

TEST(MotionClassifier, AMovingTrackStopsAfterTwoSlowScans) {
  const TrackedObject slow = object(0, kWell_mps), fast = object(kFast_mps, kWell_mps);
  const TrackMotion once = next(moving(), slow, kDisplaced_m);
  EXPECT_TRUE(once.moves);
  EXPECT_FALSE(next(once, slow, kDisplaced_m).moves);
  const TrackMotion fast_again = next(once, fast, kDisplaced_m);
  EXPECT_TRUE(fast_again.moves);
  EXPECT_TRUE(next(fast_again, slow, kDisplaced_m).moves);
}

// 0.59 m/s is within 2 sigma of 0.3 m/s; with a sigma of 0.6 m/s it is not known.
TEST(MotionClassifier, ASlowTrackStopsWithASpeedWithinTwoSigmaOfZero) {
  const TrackMotion once = next(moving(), object(0, kWell_mps), kDisplaced_m);
  ASSERT_TRUE(once.moves && once.slow);
  EXPECT_FALSE(next(once, object(0.59, 0.3), kDisplaced_m).moves);
  EXPECT_TRUE(next(once, object(0.61, 0.3), kDisplaced_m).moves);
  EXPECT_TRUE(next(once, object(0.59, 0.6), kDisplaced_m).moves);
}

TEST(MotionClassifier, AKnownSlowTrackWithoutDisplacementStopsAtOnce) {
  EXPECT_FALSE(next(moving(), object(0, kWell_mps), kNotDisplaced_m).moves);
  EXPECT_TRUE(next(moving(), object(0, kBadly_mps), kNotDisplaced_m).moves);
  EXPECT_TRUE(next(moving(), object(0, kWell_mps), kDisplaced_m).moves);
  EXPECT_TRUE(next(moving(), object(kFast_mps, kWell_mps), 0).moves);
}

// 4 m/s for 0.1 s are 0.4 m; three such scans are 1.2 m.
TEST(MotionClassifier, AMetreByItsSpeedWithoutDisplacementStopsATrack) {
  const TrackedObject fast = object(4, kWell_mps);
  TrackMotion state = moving();
  for (const double unconfirmed_m : {0.4, 0.8}) {
    state = MotionClassifier(parameters())
                .update(state, fast, {kNotDisplaced_m, 0}, state.seen + Duration::from_seconds(0.1));
    EXPECT_NEAR(state.unconfirmed_m, unconfirmed_m, 1e-9);
    EXPECT_TRUE(state.moves);
  }
  const Time third = state.seen + Duration::from_seconds(0.1);
  EXPECT_FALSE(MotionClassifier(parameters()).update(state, fast, {kNotDisplaced_m, 0}, third).moves);
  const TrackMotion advanced = MotionClassifier(parameters()).update(state, fast, {kDisplaced_m, 0}, third);
  EXPECT_TRUE(advanced.moves);
  EXPECT_EQ(advanced.unconfirmed_m, 0);
}

TEST(MotionClassifier, TheUnconfirmedPathEndsAtOneMetre) {
  TrackMotion state = moving();
  state.unconfirmed_m = 0.59;
  EXPECT_TRUE(next(state, object(4, kWell_mps), kNotDisplaced_m).moves);  // 0.99 m
  state.unconfirmed_m = 0.61;
  EXPECT_FALSE(next(state, object(4, kWell_mps), kNotDisplaced_m).moves);  // 1.01 m
}

// Seen again after 0.3 s: a path of 1.2 m.
TEST(MotionClassifier, ThePathWhileUnseenCounts) {
  const Time now = kStart + Duration::from_seconds(0.3);
  EXPECT_FALSE(
      MotionClassifier(parameters()).update(moving(), object(4, kWell_mps), {kNotDisplaced_m, 0}, now).moves);
}

TEST(EraseDropped, ErasesTracksUnseenForMoreThanASecond) {
  TrackMotions states;
  states[3].seen = kStart;
  states[5].seen = kStart + Duration::from_nanoseconds(1);
  erase_dropped(states, kStart + Duration::from_seconds(1));
  EXPECT_EQ(states.size(), 2u);
  erase_dropped(states, kStart + Duration::from_seconds(1) + Duration::from_nanoseconds(1));
  ASSERT_EQ(states.size(), 1u);
  EXPECT_EQ(states.begin()->first, 5u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
