#pragma once

#include <vector>

#include "detection/evidence/evidence_collector.hpp"
#include "detection/evidence/point_evidence.hpp"

namespace mapless::inline v1 {

/// This folder turns rays into votes. In: the points of one scan (the query scan), its own ray image, and the
/// ray images of several reference scans. Out: one PointEvidence per return. Nothing here decides whether a
/// point or an object is dynamic, and nothing outside changes the evidence: segmentation and tracking read
/// it.
///
/// Point by point this is the freespace check of paper step 3 against each reference scan; the comparison of
/// step 2 is its answer `border`. Not every point is queried (ScanlineSampler). The result does not depend on
/// the number of threads. `explanation`: records gaps, sources and observations; null: nothing. `others`:
/// earlier scans of other sensors on the same vehicle.
[[nodiscard]] std::vector<PointEvidence> collect_evidence(const LidarScan& scan, const LocalPoints& points,
                                                          const std::vector<ReferenceScan>& references,
                                                          const RayImage& own,
                                                          const VotingParameters& parameters,
                                                          ScanExplanation* explanation = nullptr,
                                                          const std::vector<ReferenceScan>& others = {});

}  // namespace mapless
