#pragma once

#include <cstdint>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/evidence_growth.hpp"
#include <mapless/detection/explanation.hpp>

namespace mapless::inline v1 {

/// Enters what segmentation saw of each point in ScanExplanation::points: votes, support and labelled
/// neighbours, from the same evidence and neighbourhoods as filter_evidence and grow_evidence.
void explain_segmentation(const LidarScan& scan, const LocalPoints& points,
                          const std::vector<PointEvidence>& votes, const EvidenceGrowthResult& regions,
                          const VotingParameters& parameters, ScanExplanation& explanation);

}  // namespace mapless
