#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "detection/freespace/ray_image.hpp"
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// A scan that is asked about another: so many scans before it, or after it where `gap` is below 0.
struct AskedScan {
  const RayImage* image = nullptr;
  int gap = 1;
};

/// What a scan's answer counts.
///
/// - It saw through the point's place: kSeenThroughVotes where the nearest ray passed within
///   kThroughItself_m of it, or met nothing at all: what stands hardly ever looks like that. Where the ray
///   passed farther above, below or beside it and ended on something else, kSeenPastVotes: so do rails,
///   ridges and leaves between two lasers look, and poles between two firings, scan after scan.
/// - It saw a surface there: 1 vote against for the nearest scans up to kMostSurfaceVotes for the farthest
///   (surface_votes). Slow things and surfaces that slide within themselves are where they were a moment ago,
///   and not where they were seconds ago. But where that surface was proposed to move then: none, and
///   kMovingVotes from a scan within kRecentGap. Whether the thing still goes on, its own motion tells
///   (MovingObjects).
/// - Something hid the place that has left its own since, as the scan asked about shows, and that was no
///   farther off than VotingParameters::vacated_m: kVacatedVotes. It is the thing itself, moving away. Later
///   scans but the nearest are not heard here: by then something may have come before a wall. And
///   not where the later scan sees a surface at the point that would have gone on by more than kClearlyGone
///   tolerances by then, by how far the hider had been off, or by clearly more than that surface is off the
///   point: such a point was uncovered.
/// - Else it could not see: none.
inline constexpr int kSeenThroughVotes = 4;
inline constexpr int kSeenPastVotes = 2;
inline constexpr float kThroughItself_m = 0.07F;
inline constexpr int kVacatedVotes = 2;
inline constexpr int kMovingVotes = 1;
inline constexpr int kMostSurfaceVotes = 4;
inline constexpr float kClearlyGone = 2;
[[nodiscard]] int surface_votes(int gap);
/// A scan no farther off than this tells whether something moves now; where all are farther, the nearest
/// does.
inline constexpr int kRecentGap = 4;

/// The sum of what other scans say of one point.
struct PointVotes {
  std::int16_t earlier = 0;       ///< of the earlier scans
  std::int16_t later = 0;         ///< of the later scan
  bool seen_through : 1 = false;  ///< some scan saw through
  bool surface_seen : 1 = false;  ///< some scan saw a surface
  bool recently : 1 = false;  ///< seen through, or vacated, by a scan that tells whether something moves now
  bool vacated : 1 = false;   ///< what hid it from some scan has left
  bool moving_seen : 1 = false;  ///< a scan a moment ago saw a surface there and it was found moving

  [[nodiscard]] int total() const { return earlier + later; }
};

/// Puts every point of a scan, whose own rays are `own`, to the scans `asked`. One element per return. Point
/// by point this is the freespace check of paper step 3; the comparison of step 2 is its border answer.
[[nodiscard]] std::vector<PointVotes> collect_votes(const LidarScan& scan, const LocalPoints& points,
                                                    const std::vector<AskedScan>& asked, const RayImage& own,
                                                    const VotingParameters& parameters);

}  // namespace mapless
