#include "detection/tracking/motion_classifier.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "detection/evidence/point_evidence.hpp"
#include "detection/tracking/longest_absence.hpp"

namespace mapless::inline v1 {
namespace {

// Scans in which a track may move without a known velocity: the first has nothing to be registered to, the
// second one displacement.
constexpr int kYoungScans = 2;

// A velocity is known to this standard deviation [m/s], or if it differs from zero by more than this many of
// them: 95 % of a Gaussian lies within 2.
constexpr double kKnownStd_mps = 0.5;
constexpr double kSignificance = 2;

// Evidence, relative to what a track takes to begin, that suffices whatever its velocity. That of an object
// that passes a window or crosses a fan of beams may never be known, while rays pass through its place in
// every scan.
constexpr double kSufficientRayEvidence = 2;

// Evidence to begin, by body, relative to min_evidence. Part of a rigid body is never seen through, so a
// quarter suffices; leaves, rails and edges gather votes while they are static, but hardly ever a velocity.
// Measured: both factors at 1 cost .004 IoU (HDL-64E) and .008 (VLP-16) over 24 recordings of a second
// simulator, and nothing (less than .001) over those of `mapless benchmark`.
constexpr double kRigidFactor = 0.25;
constexpr double kPorousFactor = 1.5;

// Path without a displacement shown by the rays: several times the least they show (min_displacement_m).
// Measured without it: no effect with true poses; along own odometry, IoU .433 to .404 (tunnel, Pandar64,
// seed 7, 2.5 s).
constexpr double kMaxUnconfirmed_m = 1;

// A static object comes into view bit by bit, and its velocity errs by as much as its seen part grows, while
// the rays show no displacement. After this many static scans they have to show this share of its path.
constexpr int kStaticScans = 3;
constexpr double kConfirmedShare = 0.5;

bool differs_from_zero(const TrackedObject& object) {
  const double square = object.velocity_0.dot(object.velocity_covariance_0.ldlt().solve(object.velocity_0));
  return square > kSignificance * kSignificance;
}

// Factor on the evidence that a track takes to begin.
double body_factor(Body body, const TrackedObject& object) {
  if (body == Body::rigid) return kRigidFactor;
  const bool known = object.age > kYoungScans && object.velocity_std_0().maxCoeff() <= kKnownStd_mps;
  return body == Body::porous && !known ? kPorousFactor : 1;
}

// Whether the displacement that rays show confirms the velocity, over the scans they compare (kRecentGap).
bool confirms_velocity(const TrackMotion& last, const TrackedObject& object, const ObjectEvidence& evidence,
                       Time now) {
  const double scans = object.age - last.age;
  const double path_m = object.velocity_0.norm() * (now - last.seen).seconds() * kRecentGap / scans;
  return static_cast<double>(evidence.displacement_m) >= kConfirmedShare * path_m;
}

// Part of the evidence needed to begin with which an object of badly known velocity goes on. Chosen: half of
// it, so that evidence about the limit does not switch an object on and off.
constexpr double kGoesOnShare = 0.5;

}  // namespace

// The worse its velocity is known, once there was time to know it, the more: a porous object is found
// elsewhere in every scan.
double MotionClassifier::required_evidence(const TrackedObject& object) const {
  const double std_mps = object.age > kYoungScans ? object.velocity_std_0().maxCoeff() : 0;
  return parameters_.min_evidence * std::max(1.0, std_mps / kKnownStd_mps);
}

TrackMotion MotionClassifier::update(const TrackMotion& last, const TrackedObject& object,
                                     const ObjectEvidence& evidence, Time now) const {
  const bool displaced = static_cast<double>(evidence.displacement_m) >= parameters_.min_displacement_m;
  const bool differs = differs_from_zero(object);
  const bool known = differs || object.velocity_std_0().maxCoeff() <= kKnownStd_mps;
  TrackMotion next;
  next.seen = now;
  next.age = object.age;
  next.velocity_known = last.velocity_known || known;
  next.evidence = std::ldexp(last.evidence, last.age - object.age) + std::max(evidence.votes, 0);
  if (object.age > 1) {
    const double speed_mps = object.velocity_0.norm();
    next.slow = known ? speed_mps < parameters_.min_speed_mps : !displaced;
    next.unconfirmed_m = displaced ? 0 : last.unconfirmed_m + speed_mps * (now - last.seen).seconds();
  }
  next.static_scans = last.moves ? 0 : last.static_scans + (known && next.slow ? 1 : 0);

  const double required = required_evidence(object);
  const bool young = object.age <= kYoungScans && evidence.votes >= 0;
  const bool plausible = next.velocity_known || young || next.evidence >= kSufficientRayEvidence * required;
  // Before it has moved, a velocity that was known and is no longer may be zero, too.
  const bool was_known = !last.moves && last.velocity_known;
  const bool may_be_zero = object.age > 1 && (known || was_known) && !differs;
  if (last.moves) {
    const bool stays_slow = (next.slow && (last.slow || (known && !displaced))) || (last.slow && may_be_zero);
    const bool unsupported = required > parameters_.min_evidence && next.evidence < kGoesOnShare * required;
    next.moves = plausible && !stays_slow && next.unconfirmed_m < kMaxUnconfirmed_m && !unsupported;
    next.reason = next.moves     ? TrackReason::goes_on
                  : !plausible   ? TrackReason::velocity_unknown
                  : stays_slow   ? TrackReason::stopped_slow
                  : !unsupported ? TrackReason::stopped_unconfirmed
                                 : TrackReason::stopped_unsupported;
  } else {
    const bool confirmed = last.static_scans < kStaticScans || confirms_velocity(last, object, evidence, now);
    next.required = body_factor(evidence.body, object) * required;
    next.moves =
        plausible && displaced && confirmed && !next.slow && !may_be_zero && next.evidence >= next.required;
    next.reason = next.moves    ? TrackReason::begins
                  : !plausible  ? TrackReason::velocity_unknown
                  : !displaced  ? TrackReason::not_displaced
                  : !confirmed  ? TrackReason::not_confirmed
                  : next.slow   ? TrackReason::slow
                  : may_be_zero ? TrackReason::may_be_zero
                                : TrackReason::little_evidence;
  }
  return next;
}

void erase_dropped(TrackMotions& states, Time now) {
  std::erase_if(states,
                [now](const auto& entry) { return (now - entry.second.seen).seconds() > kLongestAbsence_s; });
}

}  // namespace mapless
