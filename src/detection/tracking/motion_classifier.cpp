#include "detection/tracking/motion_classifier.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "detection/evidence/point_evidence.hpp"
#include "detection/tracking/longest_absence.hpp"

namespace mapless::inline v1 {
namespace {

// Scans of a track before its velocity can be known well: the first has nothing to be registered to, the
// second one displacement.
constexpr int kYoungScans = 2;

// A velocity is known to this standard deviation [m/s], or if it differs from zero by more than this many of
// them: 95 % of a Gaussian lies within 2.
constexpr double kKnownStd_mps = 0.5;
constexpr double kSignificance = 2;

// Evidence to begin, relative to min_evidence. What stood there before gathers votes while it is static:
// leaves, rails and edges, seen through by one scan and hit by another. So do lines. A body that rays never
// saw through in part, or whose place they show to change as its velocity says, needs less. Measured:
// docs/notebook/ detection.md, "What stood there before".
constexpr double kStandingFactor = 2;
constexpr double kSureFactor = 0.5;

// Least displacement that rays show of one that confirms a velocity, as a share of its path. A static object
// comes into view bit by bit, and its velocity errs by as much as its seen part grows. Measured: .75 costs
// .005 IoU (VLP-16), .25 gives .03 false objects a scan.
constexpr double kConfirmedShare = 0.5;

bool differs_from_zero(const TrackedObject& object) {
  const double square = object.velocity_0.dot(object.velocity_covariance_0.ldlt().solve(object.velocity_0));
  return square > kSignificance * kSignificance;
}

// Whether the displacement that rays show over the scans they compare (kRecentGap) confirms the velocity.
bool confirms_velocity(const TrackMotion& last, const TrackedObject& object, const ObjectEvidence& evidence,
                       Time now) {
  const double scans = object.age - last.age;
  const double path_m = object.velocity_0.norm() * (now - last.seen).seconds() * kRecentGap / scans;
  return static_cast<double>(evidence.displacement_m) >= kConfirmedShare * path_m;
}

// Factor on the evidence that a track takes to begin. `sure`: its velocity is, and the rays confirm it.
double body_factor(Body body, bool sure) {
  if (body == Body::standing || body == Body::line) return kStandingFactor;
  return sure || body == Body::rigid ? kSureFactor : 1;
}

// So that three scans of the other kind are heard. Measured: 7 and 10 find .1 and .03 IoU less past guard
// rails.
constexpr double kMostLogOdds = 20;

double share_counted(const TrackMotion& motion) {
  return std::min(1.0, kOddsOfMover * std::exp(motion.log_odds));
}

// Faint clusters about a track with which it takes twice the evidence. Measured: any from 2 to 8 halves the
// false objects among leaves (docs/notebook/detection.md, "Clutter").
constexpr double kClutter = 3;

// Part of the evidence needed to begin with which an object of badly known velocity goes on, so that evidence
// about the limit does not switch it on and off. Measured: half of it costs .007 IoU (VLP-16).
constexpr double kGoesOnShare = 1.0 / 3;

// Cosine of the largest angle between a line and a velocity along it: 25 degrees. Measured on 80 recordings
// (VLP-16): .5, .9, .95 stop 354, 346, 342 rails and 70, 26, 25 moving objects.
constexpr double kAlong = 0.9;

}  // namespace

// The worse its velocity is known, once there was time to know it, the more: a porous object is found
// elsewhere in every scan. And the more clutter there is about it: among leaves each scan has other clusters
// that rays seem to have passed through, and one near enough to go on with.
double MotionClassifier::required_evidence(const TrackedObject& object, double clutter) const {
  const double std_mps = object.age > kYoungScans ? object.velocity_std_0().maxCoeff() : 0;
  return parameters_.min_evidence * std::max(1.0, std_mps / kKnownStd_mps) * (1 + clutter / kClutter);
}

TrackMotion MotionClassifier::update(const TrackMotion& last, const TrackedObject& object,
                                     const ObjectEvidence& evidence, Time now, bool on_path) const {
  const bool displaced = static_cast<double>(evidence.displacement_m) >= parameters_.min_displacement_m;
  const bool differs = differs_from_zero(object);
  const bool known = differs || object.velocity_std_0().maxCoeff() <= kKnownStd_mps;
  TrackMotion next;
  next.seen = now;
  next.age = object.age;
  next.velocity_known = last.velocity_known || known;
  next.evidence = std::ldexp(last.evidence, last.age - object.age) + std::max(evidence.votes, 0);
  next.clutter = last.age > 0 ? (last.clutter + evidence.clutter) / 2 : evidence.clutter;
  next.log_odds = std::clamp(std::ldexp(last.log_odds, last.age - object.age) + evidence.log_odds,
                             -kMostLogOdds, kMostLogOdds);
  if (object.age > 1) next.slow = known ? object.velocity_0.norm() < parameters_.min_speed_mps : !displaced;
  next.stood = !last.moves && (last.stood || (known && next.slow));
  if (on_path) {
    next.moves = true;
    next.reason = TrackReason::follows_path;
    return next;
  }

  const double required = required_evidence(object, next.clutter);
  if (last.moves) {
    const bool unsupported = required > parameters_.min_evidence && next.evidence < kGoesOnShare * required;
    next.moves = !next.slow && !unsupported;
    next.reason = next.moves  ? TrackReason::goes_on
                  : next.slow ? TrackReason::stopped_slow
                              : TrackReason::stopped_unsupported;
  } else {
    // A velocity that was known and is no longer may be zero, too.
    const bool may_be_zero = object.age > 1 && next.velocity_known && !differs;
    const bool confirms = confirms_velocity(last, object, evidence, now);
    next.required = body_factor(evidence.body, differs && confirms) * required / share_counted(next);
    next.moves = displaced && (confirms || !last.stood) && !next.slow && !may_be_zero &&
                 next.evidence >= next.required;
    next.reason = next.moves                ? TrackReason::begins
                  : !displaced              ? TrackReason::not_displaced
                  : last.stood && !confirms ? TrackReason::not_confirmed
                  : next.slow               ? TrackReason::slow
                  : may_be_zero             ? TrackReason::may_be_zero
                                            : TrackReason::little_evidence;
  }
  return next;
}

bool slides_with_sensor(const Eigen::Vector3f& line_0, const Eigen::Vector3d& velocity_0,
                        const Eigen::Vector3d& sensor_velocity_0) {
  return std::abs(line_0.cast<double>().dot(velocity_0)) > kAlong * velocity_0.norm() &&
         (velocity_0 - sensor_velocity_0).norm() < sensor_velocity_0.norm() / 2;
}

void erase_dropped(TrackMotions& states, Time now) {
  std::erase_if(states,
                [now](const auto& entry) { return (now - entry.second.seen).seconds() > kLongestAbsence_s; });
}

}  // namespace mapless
