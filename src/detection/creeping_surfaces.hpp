#pragma once

#include <vector>

#include <mapless/detection/freespace_votes.hpp>

namespace mapless {

/// Finds what goes on by less than VotingParameters::tolerance_m while it is in sight, so that no scan ever
/// sees through it: a braking car that comes round a corner.
///
/// Where a scan 2 to 8 before saw the face of a thing is known to some centimetres by one ray, and to some
/// millimetres by the mean over a patch of it. A patch creeps if it has advanced along its own normal, by 3
/// cm or more since each scan of 3 to 8 before, and by what a steady speed makes of each interval. Two or
/// more patches side by side creep together if the later scan finds them farther on, by 0.4 of that or more:
/// what was uncovered, or ends at another's edge, stays where it is. Without a later scan nothing is found.
/// From these the object is grown over patches that are parallel or convex to them, and do not stand, and
/// the points beside that lie on no other surface. Its points get the votes of a scan that saw through them;
/// what rays found to move by themselves is left alone.
void vote_for_creeping(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
                       const VotingParameters& parameters, std::vector<PointVotes>& votes);

}  // namespace mapless
