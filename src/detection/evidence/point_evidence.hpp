#pragma once

#include <cstdint>

namespace mapless::inline v1 {

/// Votes of one reference scan about one point of the query scan, by what its rays observed at the point.
/// docs/method.md has the table; the measurements behind each number are in docs/notebook/detection.md.
///
/// - Free: the rays passed through the point. kSeenThroughVotes where the nearest ray passed within
///   kSeenThroughWithin_m of the point or met nothing at all, since a static surface hardly ever looks like
///   that. kPassedBesideVotes where it passed farther aside and ended on something else: so rails, ridges and
///   leaves between two lasers look in every scan, and poles between two firings. Also where a ray beside it
///   ended at the point's range (Answer::surface_beside): so leaves, railings and fences look.
/// - Occupied: a ray ended on a surface at the point. surface_votes(gap) against, more for older scans: slow
///   objects, and surfaces that slide along themselves, were at the same place a moment ago, but not seconds
///   ago. If that return was itself found dynamic: no vote against, and kSeenDynamicVotes from a scan within
///   kRecentGap. Whether the object still moves is decided by its track (MovingObjects).
/// - Occluder left: the point was hidden by something within VotingParameters::max_occluder_distance_m whose
///   place the query scan observes free. kOccluderLeftVotes: it is probably the same object, moving away
///   along the rays. Counted for earlier scans and for the nearest later one; scans beyond that may have seen
///   something else come in between. See EvidenceCollector for when the departure contradicts the next scan.
/// - Moves along the rays: the ranges of many scans grow or shrink in proportion to their gaps
///   (moves_along_rays). Each scan that agrees gives kRangeRateVotes in place of its vote against.
/// - Anything else: no vote.
inline constexpr int kSeenThroughVotes = 4;
inline constexpr int kPassedBesideVotes = 2;
inline constexpr float kSeenThroughWithin_m =
    0.07F;  // measured: docs/notebook/detection.md, "passes a point by"
inline constexpr int kOccluderLeftVotes = 2;
inline constexpr int kSeenDynamicVotes = 1;
inline constexpr int kRangeRateVotes = 2;
inline constexpr int kMaxSurfaceVotes = 4;  // as much as one scan that saw through the point

/// A scan at most this many scans away shows whether something moves now; if all reference scans are farther,
/// the nearest does. Chosen: 0.4 s at 10 scans a second.
inline constexpr int kRecentGap = 4;

/// 1 for gaps below 4, one more each time the gap doubles, up to kMaxSurfaceVotes. `gap` [scans]; of a later
/// scan (below 0) 1.
[[nodiscard]] inline int surface_votes(int gap) {
  int votes = 1;
  for (int reach = 4; reach <= gap && votes < kMaxSurfaceVotes; reach *= 2) ++votes;
  return votes;
}

/// Sum of the votes of all reference scans about one point.
struct PointEvidence {
  std::int16_t past = 0;           ///< votes of the earlier scans
  std::int16_t future = 0;         ///< votes of the later scans
  bool seen_through : 1 = false;   ///< some scan's rays passed through or close beside the point
  bool surface_seen : 1 = false;   ///< some scan observed a surface at the point
  bool recently_free : 1 = false;  ///< seen through, or its occluder left, as observed by a recent scan
  bool occluder_left : 1 = false;  ///< an occluder that hid it from some scan has left
  bool seen_dynamic : 1 = false;   ///< a recent scan saw a surface there that was found dynamic
  bool stood_before : 1 = false;   ///< a scan before the recent ones saw a surface there, not a dynamic one
  bool own_vehicle : 1 = false;    ///< a return on the sensor's own vehicle
  bool surface_last : 1 = false;   ///< voted against by the scan before, in a turn of at most .12 s
  bool surface_next : 1 = false;   ///< the same by the scan after
  bool may_be_slow : 1 = false;    ///< these two votes do not count (forgive_slow_surfaces)
  std::uint8_t rays_through = 0;   ///< scans of this sensor whose ray went on past the point, within
                                   ///< kSeenThroughWithin_m of it
  std::uint8_t rays_beside = 0;    ///< the same, farther aside or among surfaces
  float beside_m = 0;              ///< sum of the distances of those beside from the point

  [[nodiscard]] int total() const { return past + future; }
  bool operator==(const PointEvidence&) const = default;
};

/// Some scan observed a surface at the point, and nothing else speaks against a static point.
[[nodiscard]] inline bool is_static(const PointEvidence& e) {
  return e.surface_seen && !e.seen_through && !e.occluder_left && !e.seen_dynamic;
}

}  // namespace mapless
