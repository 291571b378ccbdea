#include "detection/tracking/motion_classifier.hpp"

#include <cmath>

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

// A third as likely as a mover is as good as one; a sixth takes twice the evidence to begin.
TEST(MotionClassifier, WhatRaysKeepBesideTakesMoreEvidenceToBegin) {
  const auto next_with = [](TrackMotion last, double log_odds, int votes) {
    const ObjectEvidence evidence{kDisplaced_m, votes, Body::unclear, log_odds};
    return MotionClassifier(parameters())
        .update(last, object(5, kWell_mps), evidence, kStart + Duration::from_seconds(0.1));
  };
  EXPECT_TRUE(next_with(standing(), -std::log(2.99), kVotes).moves);
  EXPECT_FALSE(next_with(standing(), -std::log(6), 2 * kVotes - 1).moves);
  EXPECT_TRUE(next_with(standing(), -std::log(6), 2 * kVotes + 1).moves);
  // That of the scan before counts half, and the sum is within e^20.
  TrackMotion before = standing();
  before.log_odds = -2 * std::log(6);
  EXPECT_FALSE(next_with(before, 0, 2 * kVotes - 1).moves);
  EXPECT_TRUE(next_with(before, 0, 2 * kVotes + 1).moves);
  EXPECT_EQ(next_with(before, -100, kVotes).log_odds, -20);
  // What moves goes on.
  EXPECT_TRUE(next_with(moving(), -100, kVotes).moves);
}

// Three faint clusters about it in the mean over scans, each counted half as much as the next: twice the
// evidence.
TEST(MotionClassifier, ClutterTakesMoreEvidence) {
  const auto next_among = [](TrackMotion last, int clutter, int votes, double std_mps = kWell_mps) {
    ObjectEvidence evidence{kDisplaced_m, votes};
    evidence.clutter = clutter;
    TrackedObject o = object(5, std_mps);
    o.age = last.age + 1;
    return MotionClassifier(parameters()).update(last, o, evidence, kStart + Duration::from_seconds(0.1));
  };
  EXPECT_FALSE(next_among({}, 3, 2 * kVotes - 1).moves);
  EXPECT_TRUE(next_among({}, 3, 2 * kVotes).moves);
  TrackMotion before = standing();
  before.clutter = 6;
  EXPECT_FALSE(next_among(before, 0, 2 * kVotes - 1).moves);
  EXPECT_TRUE(next_among(before, 0, 2 * kVotes).moves);
  EXPECT_EQ(next_among(before, 2, 0).clutter, 4);
  // What moves goes on with a third of what it would take to begin, which is 200.
  EXPECT_TRUE(next_among(moving(), 6, 67).moves);
  EXPECT_FALSE(next_among(moving(), 6, 66).moves);
}

// Without evidence, slower than 0.5 m/s: both for one that stood and one that moved.
TEST(MotionClassifier, WhatIsOnAStraightPathMoves) {
  const MotionClassifier classifier(parameters());
  const Time now = kStart + Duration::from_seconds(0.1);
  for (const TrackMotion& last : {TrackMotion{}, standing(), moving()}) {
    const TrackMotion on_path = classifier.update(last, object(kSlow_mps, kWell_mps), {}, now, true);
    EXPECT_TRUE(on_path.moves);
    EXPECT_EQ(on_path.reason, TrackReason::follows_path);
    EXPECT_FALSE(classifier.update(last, object(kSlow_mps, kWell_mps), {}, now, false).moves);
  }
}

// 40 / 2 / 2 + 60 / 2 + 60 = 100, and 99 with one vote less in the last scan. Negative votes of a scan are
// not subtracted from past evidence. The displacement does not confirm 5 m/s.
TEST(MotionClassifier, PastEvidenceIsHalvedPerScan) {
  for (const int last_votes : {60, 59}) {
    TrackMotion state;
    const auto add = [&](int votes) {
      TrackedObject o = object(5, kWell_mps);
      o.age = state.age + 1;
      state = MotionClassifier(parameters())
                  .update(state, o, {kDisplaced_m, votes}, kStart + Duration::from_seconds(0.1 * o.age));
    };
    for (const int votes : {40, 60, last_votes}) {
      EXPECT_FALSE(state.moves);
      add(votes);
    }
    EXPECT_DOUBLE_EQ(state.evidence, 40 + last_votes);
    EXPECT_EQ(state.moves, last_votes == 60);
    add(-5);
    EXPECT_DOUBLE_EQ(state.evidence, (40 + last_votes) / 2.0);
  }
}

TEST(MotionClassifier, EvidenceIsHalvedForUnseenScansToo) {
  TrackedObject o = object(kFast_mps, kWell_mps);
  o.age = 1;
  const TrackMotion first = next({}, o, kDisplaced_m, 80);
  o.age = 4;
  EXPECT_DOUBLE_EQ(next(first, o, kDisplaced_m, 90).evidence, 100);
}

// Whether a track begins in 0.1 s with these votes, but not with one less.
bool needs(int votes, const TrackedObject& o, float displacement_m, Body body) {
  const auto moves = [&](int v) {
    return MotionClassifier(parameters())
        .update(standing(), o, {displacement_m, v, body}, kStart + Duration::from_seconds(0.1))
        .moves;
  };
  return moves(votes) && !moves(votes - 1);
}

TEST(MotionClassifier, RequiredEvidenceDependsOnTheBody) {
  const TrackedObject unknown = object(kFast_mps, kBadly_mps);
  EXPECT_TRUE(needs(kVotes / 2, unknown, kDisplaced_m, Body::rigid));
  EXPECT_TRUE(needs(kVotes, unknown, kDisplaced_m, Body::unclear));
  EXPECT_TRUE(needs(2 * kVotes, unknown, kDisplaced_m, Body::standing));
}

// 2 m/s are 0.8 m in four scans of 0.1 s, of which the rays have to show half; 2 m/s are sure to 0.99 m/s,
// two deviations. What stood before takes twice the evidence all the same.
TEST(MotionClassifier, ASureVelocityThatTheRaysConfirmNeedsHalfTheEvidence) {
  EXPECT_TRUE(needs(kVotes / 2, object(2, 0.99), 0.41F, Body::unclear));
  EXPECT_TRUE(needs(kVotes, object(2, 0.99), 0.39F, Body::unclear));
  EXPECT_TRUE(needs(kVotes, object(2, 1.01), 0.41F, Body::unclear));
  EXPECT_TRUE(needs(2 * kVotes, object(2, 0.99), 0.41F, Body::standing));
  TrackedObject o = object(2, 0.99);
  o.age = 3;  // not seen in the scan between: two scans in 0.1 s
  EXPECT_TRUE(needs(static_cast<int>(std::lround(kVotes / 2 * 0.99 / 0.5)), o, kDisplaced_m, Body::unclear));
}

TEST(MotionClassifier, AMovingTrackWithKnownVelocityNeedsNoEvidence) {
  EXPECT_TRUE(next(moving(), object(kFast_mps, kWell_mps), kDisplaced_m, 0).moves);
}

// A standard deviation of 1.5 m/s is three times 0.5 m/s: a track begins with three times the evidence and
// continues with a third of that. The displacement does not confirm 5 m/s.
TEST(MotionClassifier, RequiredEvidenceGrowsWithTheStandardDeviation) {
  TrackedObject o = object(5, 1.5);
  o.age = 3;
  TrackMotion known = standing();
  known.velocity_known = true;
  known.age = 2;
  EXPECT_FALSE(next(known, o, kDisplaced_m, 3 * kVotes - 1).moves);
  EXPECT_TRUE(next(known, o, kDisplaced_m, 3 * kVotes).moves);
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

TEST(MotionClassifier, TheSpeedOfANewTrackIsIgnored) {
  TrackedObject o = object(0, kWell_mps);
  o.age = 1;
  const TrackMotion state = next({}, o, kDisplaced_m);
  EXPECT_TRUE(state.moves);
  EXPECT_FALSE(state.slow);
  o.velocity_0 = {0, 20, 0};
  EXPECT_FALSE(next({}, o, 0).moves);
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
TEST(MotionClassifier, OfWhatWasSeenToStandTheRaysHaveToConfirmHalfOfTheVelocity) {
  TrackMotion state = standing();
  for (const bool stood : {false, true}) {
    state.stood = stood;
    EXPECT_EQ(next(state, object(2, kWell_mps), 0.39F).moves, !stood);
    EXPECT_TRUE(next(state, object(2, kWell_mps), 0.41F).moves);
  }
  EXPECT_EQ(next(state, object(2, kWell_mps), 0.39F).reason, TrackReason::not_confirmed);
}

// Until it moves: with a known and slow velocity, whatever comes between.
TEST(MotionClassifier, AKnownSlowVelocityShowsThatATrackStands) {
  EXPECT_FALSE(next(standing(), object(0, kBadly_mps), kNotDisplaced_m).stood);  // slow, but not known
  TrackMotion state = next(standing(), object(kSlow_mps, kWell_mps), kDisplaced_m);
  EXPECT_TRUE(state.stood);
  state = next(state, object(kFast_mps, kWell_mps), kNotDisplaced_m);
  EXPECT_TRUE(state.stood);
  state.moves = true;
  EXPECT_FALSE(next(state, object(kSlow_mps, kWell_mps), kNotDisplaced_m).stood);
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

// Below min_speed_mps where the velocity is known, else without a displacement.
TEST(MotionClassifier, AMovingTrackStopsWhenItIsSlow) {
  EXPECT_TRUE(next(moving(), object(kFast_mps, kWell_mps), kNotDisplaced_m).moves);
  const TrackMotion stopped = next(moving(), object(kSlow_mps, kWell_mps), kDisplaced_m);
  EXPECT_FALSE(stopped.moves);
  EXPECT_EQ(stopped.reason, TrackReason::stopped_slow);
  EXPECT_TRUE(next(moving(), object(0, kBadly_mps), kDisplaced_m).moves);
  EXPECT_FALSE(next(moving(), object(0, kBadly_mps), kNotDisplaced_m).moves);
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

// Velocities 24 and 27 degrees off the line, either way along it; nearer to the sensor's than to none.
TEST(SlidesWithSensor, WhatMovesAlongItsLineAtTheSensorsVelocity) {
  const Vector3d sensor_mps{2, 0, 0};
  const auto slides = [&](const Eigen::Vector3f& line, const Vector3d& velocity_0) {
    return slides_with_sensor(line, velocity_0, sensor_mps);
  };
  for (const float sign : {1.F, -1.F}) {
    const Eigen::Vector3f line{sign, 0, 0};
    EXPECT_TRUE(slides(line, {2, 0.89, 0}));
    EXPECT_FALSE(slides(line, {1.5, 0.76, 0}));
    EXPECT_TRUE(slides(line, {1.01, 0, 0}));
    EXPECT_FALSE(slides(line, {0.99, 0, 0}));
    EXPECT_FALSE(slides(line, {3.01, 0, 0}));
    EXPECT_FALSE(slides(line, {-2, 0, 0}));
  }
  EXPECT_FALSE(slides({0, 1, 0}, {2, 0, 0}));
  EXPECT_FALSE(slides(Eigen::Vector3f::Zero(), {2, 0, 0}));
  EXPECT_FALSE(slides_with_sensor({1, 0, 0}, Vector3d::Zero(), Vector3d::Zero()));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
