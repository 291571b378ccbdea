#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <mapless/detection/detection.hpp>

namespace mapless::inline v1 {

// How method "voting" came to the labels of one scan: recorded while it decides, not worked out afterwards
// (Detector::explain). docs/method.md has the method.

/// What became of the thing that a ray hit in front of a point (Observation, verdict `outside`).
enum class OccluderVerdict : std::uint8_t {
  not_examined,  ///< farther than max_occluder_distance_m, or a later scan but the next
  still_there,   ///< the query scan does not observe its place free
  left,          ///< the query scan observes its place free: probably the same object, moving away
  contradicted   ///< its place is free, but the next scan saw a surface at the point all the same
};

/// What one reference scan observed at one point, and the votes it gave for it.
struct Observation {
  FreespaceVerdict verdict = FreespaceVerdict::not_evaluated;  ///< not_evaluated: settled before, not queried
  OccluderVerdict occluder = OccluderVerdict::not_examined;
  bool returned = false;          ///< the nearest ray has a return; without one it met nothing within range
  bool seen_dynamic = false;      ///< that return was found dynamic
  bool agrees = false;            ///< with a steady motion along the rays (moves_along_rays)
  std::int16_t votes = 0;         ///< for a dynamic point; below 0 against
  std::int32_t laser = -1;        ///< of the ray that passes nearest; -1: none passes near
  float short_by_m = 0;           ///< how far before the point it ended; below 0 beyond; NaN: not known
  float aside_m = 0;              ///< how far from the point it passes
  float occluder_distance_m = 0;  ///< from the point to the occluder, where `occluder` was examined
};

/// How a point that its votes put in no object came to belong to a dynamic one.
enum class Completion : std::uint8_t {
  none,
  body,  ///< it lies within the object's radius (complete_bodies)
  side   ///< of the plane of its side, which slides along itself (SlidingSides)
};

/// What the steps decided about one return.
struct PointDecision {
  std::int16_t past = 0, future = 0;  ///< sums of the votes of earlier and of later scans
  bool seen_through = false;          ///< some scan's rays passed through the point or beside it
  bool surface_seen = false;          ///< some scan observed a surface at the point
  bool occluder_left = false;
  bool may_be_slow = false;         ///< the votes against it by the scans before and after do not count
  bool own_vehicle = false;         ///< it lies on the sensor's own vehicle and counts as seen by all scans
  std::int16_t support = 0;         ///< its votes and those of its linked neighbours in the 3 x 5 window
  std::uint8_t supporters = 0;      ///< linked neighbours in that window, of 14
  std::uint8_t near_labelled = 0;   ///< of them, those in a proposed object
  std::uint8_t reach_labelled = 0;  ///< linked neighbours in a proposed object in the 5 x 9 window, of 44
  std::uint16_t proposed = 0;       ///< number of the proposed object it belongs to, 0: none
  GrowthVerdict growth = GrowthVerdict::not_reached;
  Completion completed = Completion::none;  ///< added to a dynamic object, `proposed`, after all of these

  [[nodiscard]] int votes() const { return past + future; }
};

/// Why an object is dynamic or static in one scan: the first condition of MotionClassifier that decided.
enum class TrackReason : std::uint8_t {
  goes_on,              ///< it moved in the scan before, and nothing says that it stopped
  begins,               ///< all conditions to begin hold
  follows_path,         ///< its places of the last second follow one velocity (StraightPaths)
  slow,                 ///< begins not: below min_speed_mps
  may_be_zero,          ///< begins not: its velocity is within 2 sigma of zero
  not_displaced,        ///< begins not: the rays show no displacement of min_displacement_m
  not_confirmed,        ///< begins not: seen to stand, and the displacement does not confirm the velocity
  little_evidence,      ///< begins not: its evidence is below what it takes
  stopped_slow,         ///< stops: below min_speed_mps, or of unknown velocity and without a displacement
  stopped_unsupported,  ///< stops: velocity known badly, and evidence below a third of what it takes
  stopped_by_rays,      ///< the rays of the scans around show that it stands, whatever its velocity
  slides_with_sensor    ///< its points lie on a line along its velocity, which is that of the sensor: a rail
};

/// What tracking decided about one proposed object of one scan.
struct ObjectDecision {
  TrackedObject object;       ///< `number` among the proposed objects (PointDecision::proposed); `id` 0: none
  std::uint32_t track = 0;    ///< number of its track, which a static object has, too
  bool moves = false;         ///< now; only these keep their points dynamic
  bool moved_before = false;  ///< in its scan before
  TrackReason reason = TrackReason::begins;
  int votes = 0;              ///< of its points in this scan, weighted (ObjectEvidence::votes)
  double evidence = 0;        ///< of this scan, plus that of earlier ones, halved per scan
  double required = 0;        ///< evidence it takes to begin
  double clutter = 0;         ///< sets of points within 3 m, too faint for objects; mean over its scans
  double displacement_m = 0;  ///< shown by the rays
};

/// Limits between two decisions that no parameter gives.
struct DecisionLimits {
  double tolerance_m = 0;       ///< VotingParameters::tolerance_m, raised for the noise of the scan
  double through_within_m = 0;  ///< a ray that passes farther aside and has a return gives fewer votes
  int fill_neighbours = 0;      ///< labelled linked neighbours in the 3 x 5 window, to fill a hole
  int firmly_static_votes = 0;  ///< below, a point is neither filled in nor grown over
};

/// The whole record of one scan.
struct ScanExplanation {
  Time start;                    ///< of the scan
  bool points_recorded = false;  ///< else only `objects` is filled
  DecisionLimits limits;
  std::vector<int> gaps;  ///< of the reference scans in the order of queries; below 0: later scans
  /// Per return: the return whose evidence it has. Itself if the reference scans were queried about it; else
  /// a neighbour on the same surface (ScanlineSampler).
  std::vector<std::int32_t> source;
  /// Of return i by reference scan k, at i x gaps.size() + k; only of returns with source[i] == i.
  std::vector<Observation> observations;
  std::vector<PointDecision> points;    ///< one per return
  std::vector<ObjectDecision> objects;  ///< all proposed ones, by number
};

}  // namespace mapless
