#pragma once

#include <cstdint>
#include <map>

#include <Eigen/Core>

#include "detection/segmentation/object_evidence.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/detection/explanation.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// Rails and kerbs beside a moving sensor keep their ranges, as a vehicle of its speed does, and gather votes
/// of rays beside them. Unless the rays of the last scans are a third as likely for a mover as for a thin
/// thing, its evidence counts that much less before it moves. Measured: any from 2 to 5 gives the same within
/// .003.
inline constexpr double kOddsOfMover = 3;

/// Whether the object of a track moves, and what the classification of its next scan needs of its last.
struct TrackMotion {
  bool moves = false;
  bool slow = false;            ///< its speed in the last scan was below min_speed_mps
  bool stood = false;           ///< in some scan since it last moved its velocity was known, and slow
  bool velocity_known = false;  ///< in some scan, see MotionClassifier
  double evidence = 0;          ///< votes of the last scan, plus those of earlier ones halved per scan
  double clutter = 0;           ///< ObjectEvidence::clutter, averaged with that of the scan before
  double log_odds = 0;          ///< ObjectEvidence::log_odds, summed likewise, within +-kMostLogOdds
  int age = 0;                  ///< TrackedObject::age
  Time seen;                    ///< start of its last scan
  TrackReason reason = TrackReason::begins;  ///< why it moves, or does not
  double required = 0;                       ///< evidence that it takes to begin
};

/// Classifies tracks as moving or static, from their velocity and the rays' evidence.
///
/// A velocity is known if its largest standard deviation per axis is at most 0.5 m/s, or if it differs from
/// zero by more than 2 sigma. Rays show a displacement if ObjectEvidence::displacement_m is at least
/// min_displacement_m.
///
/// A track begins to move if all of these hold:
/// - its speed is at least min_speed_mps, and a velocity that is known, or was once, differs from zero by
///   more than 2 sigma (in its first scan there is no velocity);
/// - the rays show a displacement, and half of the path that its velocity makes in kRecentGap scans if it
///   was seen to stand;
/// - its evidence reaches min_evidence, times the standard deviation of its velocity over 0.5 m/s from its
///   third scan on. A body that stood there before, or is a line, takes twice as much. Half suffices for a
///   rigid one, and where the velocity differs from zero by more than 2 sigma and the rays show half of that
///   path. Where rays keep beside it as beside a rail (`log_odds`), it takes that much more; and in clutter,
///   as among leaves: twice as much with three faint clusters about it, in the mean over its scans.
///
/// What is on a straight path (StraightPaths) moves, whatever else holds, until StandingTest says otherwise.
///
/// A moving track stops if any of these holds (or if StandingTest says so, which MovingObjects asks):
/// - its speed is below min_speed_mps;
/// - it is in clutter, or its velocity is known worse than to 0.5 m/s, and its evidence falls below a third
///   of what that takes.
///
/// Where the velocity is not known (a wall, which slides along itself at any speed), `slow` is the absence of
/// a displacement instead.
class MotionClassifier {
 public:
  explicit MotionClassifier(const VotingParameters& parameters) : parameters_(parameters) {}

  /// The state of a track after the scan that starts at `now`, in which it is `object` with `evidence`.
  /// `last` is its state before, TrackMotion{} for a new track; `on_path`: StraightPaths found it there.
  [[nodiscard]] TrackMotion update(const TrackMotion& last, const TrackedObject& object,
                                   const ObjectEvidence& evidence, Time now, bool on_path = false) const;

 private:
  [[nodiscard]] double required_evidence(const TrackedObject& object, double clutter) const;

  VotingParameters parameters_;
};

/// Whether the velocity of an object is along the line on which its points lie (within 25 degrees), and
/// differs from the sensor's by less than half of the sensor's speed. A static rail or kerb is registered so:
/// only the ends of a line show a motion along it, and the part of a rail in view moves with the sensor.
/// `line_0`: ObjectEvidence::line_0; velocities in m/s, frame 0.
[[nodiscard]] bool slides_with_sensor(const Eigen::Vector3f& line_0, const Eigen::Vector3d& velocity_0,
                                      const Eigen::Vector3d& sensor_velocity_0);

using TrackMotions = std::map<std::uint32_t, TrackMotion>;  // by TrackedObject::id

/// Erases tracks that ObjectTracker has dropped: their ids are not given again.
void erase_dropped(TrackMotions& states, Time now);

}  // namespace mapless
