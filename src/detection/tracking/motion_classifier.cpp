#include "detection/tracking/motion_classifier.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "detection/evidence/point_evidence.hpp"
#include "detection/tracking/longest_absence.hpp"

namespace mapless::inline v1 {
namespace {

// Scans an object may move in without its velocity being known: one has nothing to be registered to, the
// next has little.
constexpr int kUntoldScans = 2;

// A velocity tells more than the advance where its standard deviation is at most so large, or it is more
// than so many of them.
constexpr double kKnownStd_mps = 0.5;
constexpr double kSure = 2;

// So many times the evidence it takes an object moves by, whatever its velocity: of what passes a window, or
// crosses a fan of beams, that may never be known, and rays see through its place all the while.
constexpr double kBeyondDoubt = 2;

// A body of which a part was never seen through is there, and few votes tell that it goes; leaves, rails and
// edges gather votes while they stand, but hardly a velocity.
constexpr double kOfSolid = 0.25;
constexpr double kOfFlickering = 1.5;

constexpr double kMostUnproven_m = 1;  // several times what the rays tell

// What stands is seen to its ends bit by bit, and its velocity errs by as much as what is seen of it grows:
// of that rays show no advance. In so many scans it stood, and of the way so much it shows.
constexpr int kStoodScans = 3;
constexpr double kShareOfWay = 0.5;

bool differs_from_zero(const TrackedObject& object) {
  return object.velocity_0.dot(object.velocity_covariance_0.ldlt().solve(object.velocity_0)) > kSure * kSure;
}

// The worse its velocity is known the more evidence an object takes, once there was time to know it: what
// flickers is found elsewhere in every scan.
double evidence_needed(const TrackedObject& object, const VotingParameters& parameters) {
  const double std_mps = object.age > kUntoldScans ? object.velocity_std_0().maxCoeff() : 0;
  return parameters.min_evidence * std::max(1.0, std_mps / kKnownStd_mps);
}

// So many times that, by what its body looks like, for what is to begin.
double times_to_begin(Body body, const TrackedObject& object) {
  if (body == Body::rigid) return kOfSolid;
  const bool told = object.age > kUntoldScans && object.velocity_std_0().maxCoeff() <= kKnownStd_mps;
  return body == Body::porous && !told ? kOfFlickering : 1;
}

// Whether rays show what a velocity says to be gone since scans of a moment ago.
bool goes_as_told(const MotionState& last, const TrackedObject& object, const ObjectEvidence& evidence,
                  Time now) {
  const double scans = object.age - last.age;
  const double way_m = object.velocity_0.norm() * (now - last.seen).seconds() * kRecentGap / scans;
  return static_cast<double>(evidence.displacement_m) >= kShareOfWay * way_m;
}

}  // namespace

MotionState next_state(const MotionState& last, const TrackedObject& object, const ObjectEvidence& evidence,
                       Time now, const VotingParameters& parameters) {
  const bool advances = static_cast<double>(evidence.displacement_m) >= parameters.min_advance_m;
  const bool differs = differs_from_zero(object);
  // Of what slides along itself, or is far, it is not.
  const bool known = differs || object.velocity_std_0().maxCoeff() <= kKnownStd_mps;
  MotionState next;
  next.seen = now;
  next.age = object.age;
  next.velocity_known = last.velocity_known || known;
  next.evidence = std::ldexp(last.evidence, last.age - object.age) + std::max(evidence.votes, 0);
  if (object.age > 1) {
    const double speed_mps = object.velocity_0.norm();
    next.slow = known ? speed_mps < parameters.min_speed_mps : !advances;
    next.unproven_m = advances ? 0 : last.unproven_m + speed_mps * (now - last.seen).seconds();
  }
  next.stood = last.moves ? 0 : last.stood + (known && next.slow ? 1 : 0);
  const bool twice = last.slow || (known && !advances);  // or both say so
  const double needed = evidence_needed(object, parameters);
  const bool untold = object.age <= kUntoldScans && evidence.votes >= 0;
  const bool believed = next.velocity_known || untold || next.evidence >= kBeyondDoubt * needed;
  const bool flickers = needed > parameters.min_evidence && next.evidence < needed / 2;
  const bool may_stand = object.age > 1 && known && !differs;
  const bool stays_slow = (next.slow && twice) || (last.slow && may_stand);
  const bool stops = stays_slow || next.unproven_m >= kMostUnproven_m || flickers;
  const bool goes = last.stood < kStoodScans || goes_as_told(last, object, evidence, now);
  const bool begins = advances && goes && !next.slow && !may_stand &&
                      next.evidence >= times_to_begin(evidence.body, object) * needed;
  next.moves = believed && (last.moves ? !stops : begins);
  return next;
}

void forget_absent(MotionStates& states, Time now) {
  std::erase_if(states,
                [now](const auto& entry) { return (now - entry.second.seen).seconds() > kLongestAbsence_s; });
}

}  // namespace mapless
