#pragma once

#include <span>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/evidence/receding_ends.hpp"

namespace mapless::inline v1 {

/// What every point of a surface that slides along itself has: as many votes as two scans that saw through.
inline constexpr int kSlidingVotes = 2 * kSeenThroughVotes;

/// Surfaces that slide along themselves: the side of a bus that starts is where it was, so that for seconds
/// all scans vote against it, and only its ends tell. Rows of linked points one end of which has receded
/// (RecedingEnds), in a stack of such rows, move as a whole, and so does what lies between them: their points
/// get kSlidingVotes, in place of all others. `lines`: of the scan, by their first return, as RowLines joins
/// them.
void hear_sliding_rows(const LidarScan& scan, const LocalPoints& points, std::span<const RowLine> lines,
                       const RecedingEnds& ends, std::vector<PointVotes>& votes);

}  // namespace mapless
