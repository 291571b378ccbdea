#pragma once

#include <cstdint>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

// Segmentation: from points to objects, method "voting", in place of paper steps 4 and 5. In: one scan with
// the evidence of each of its points, unchanged. Out: seeds, then whole objects, numbered, with the evidence
// of each. Nothing is kept between scans, and no object is dropped here: which of them move, tracking
// decides. From outside only this header and the types of object_evidence.hpp are used; disjoint_sets.hpp
// serves the published method and the own vehicle, too.

/// Labelled linked neighbours in the 3 x 5 window from which on a hole is filled: more than a third of 14.
inline constexpr int kFillNeighbours = 5;

/// Neither filling nor growth reaches points with more votes against them than three scans that saw through
/// outweigh.
inline constexpr int kFirmlyStatic = -3 * kSeenThroughVotes;

struct EvidenceGrowthResult {
  std::vector<GrowthVerdict> verdict;  ///< one per return
  /// One per return. 0: static; else 1, 2, ... 65535 (shared beyond), by lowest return index.
  std::vector<std::uint16_t> object;
  int objects = 0;
  /// Points of objects that are filled from one laser alone, where lasers are more than link_m apart: the
  /// next row beyond a body is of the ground beneath it as often as of the body. They are no part of labels,
  /// but of the object in all else: docs/notebook/detection.md, "Rims".
  std::vector<std::int32_t> rims;
  std::vector<ObjectEvidence> evidence;  ///< by object number - 1
  /// Clusters of linked points that are in no object though their votes are above 0: too little in this scan
  /// alone (StraightPaths). Not objects.
  std::vector<std::vector<std::int32_t>> faint;
};

/// Seeds, in place of the box filter: points whose votes, summed with those of their linked neighbours in the
/// 3 x 5 window of the aligned scan image, are at least seed_score. Border effects are small and fail. Points
/// whose own votes are not above 0 are not evaluated.
[[nodiscard]] std::vector<FilterVerdict> filter_evidence(const LidarScan& scan, const LocalPoints& points,
                                                         const std::vector<PointEvidence>& votes,
                                                         const VotingParameters& parameters);

/// Objects, in place of region growth:
/// 1. Clusters of fewer than min_seeds linked `seeds` are dropped.
/// 2. The others grow over linked points whose votes are above 0, or that some scan saw through and whose
///    votes are at least -12 (kFirmlyStatic).
/// 3. Two rounds fill holes: points with at least -12 votes and five or more labelled linked neighbours in
///    the 3 x 5 window. Six more rounds fill points with at least -4 votes (kTangentialVotes).
/// 4. Linked points are one object. Surfaces that slide along themselves, or that no earlier scan observed,
///    join it (TangentialSurfaces).
/// 5. Objects are numbered by their lowest return; their evidence is summed (ObjectEvidenceCollector).
/// Without `grow`, only steps 1 and 5. Then faint clusters are collected, and counted about each object.
[[nodiscard]] EvidenceGrowthResult grow_evidence(const LidarScan& scan, const LocalPoints& points,
                                                 const std::vector<PointEvidence>& votes,
                                                 const std::vector<FilterVerdict>& seeds,
                                                 const VotingParameters& parameters);

}  // namespace mapless
