#pragma once

#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Takes back the votes against points by the scan before and the scan after, where they may be of a slow
/// thing, and a turn is short. At walking pace it moves by no more than the tolerance from scan to scan:
/// these two see a surface where it is now, whether it moves or not. Their votes count only where a scan
/// before the recent ones saw a surface there, too (PointEvidence::stood_before), or where no scan found the
/// place of the point or of a linked neighbour in the 3 x 5 window free, or what hid it gone. Of a person
/// behind leaves few rays tell anything, and these votes outweighed them. Measured:
/// docs/notebook/detection.md, "Slow things".
void forgive_slow_surfaces(const LidarScan& scan, const LocalPoints& points,
                           const VotingParameters& parameters, std::vector<PointEvidence>& votes);

}  // namespace mapless
