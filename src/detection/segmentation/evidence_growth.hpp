#pragma once

#include <cstdint>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include <mapless/detection/stages.hpp>

namespace mapless::inline v1 {

struct EvidenceGrowthResult {
  std::vector<GrowthVerdict> verdict;  ///< one per return
  /// One per return. 0: static; else 1, 2, ... 65535 (shared beyond), by lowest return index.
  std::vector<std::uint16_t> object;
  int objects = 0;
  std::vector<ObjectEvidence> evidence;  ///< by object number - 1
};

/// The place of paper step 4 in method "voting": whether the votes of a point and of its linked neighbours in
/// the 3 x 5 window of the aligned scan image sum to seed_score or more. Not asked of points whose own votes
/// are not above 0.
[[nodiscard]] std::vector<BoxVerdict> filter_evidence(const LidarScan& scan, const LocalPoints& points,
                                                      const std::vector<PointVotes>& votes,
                                                      const VotingParameters& parameters);

/// The place of paper step 5: clusters of fewer than min_seeds `seeds` (kept by filter_evidence) are dropped;
/// the others grow over linked points that any scan saw through or whose votes are above 0, and fill holes:
/// points that five or more of their linked neighbours in the 3 x 5 window surround. Neither reaches points
/// with more votes against them than those of three scans that saw through; filling goes on farther over
/// those with no more than the three scans before and the later one can have. And what of those hangs
/// together with an object is a side of it that slides within itself, where it ends in front of something
/// farther and does not go on into what stands (src/detection/sliding_sides.hpp). What is linked is one
/// object, numbered in the order of its first point. The share of its points that were seen through
/// `recently`, times twice the distance of the farthest from their centroid, is about how far it went: its
/// `displacement_m`.
[[nodiscard]] EvidenceGrowthResult grow_evidence(const LidarScan& scan, const LocalPoints& points,
                                                 const std::vector<PointVotes>& votes,
                                                 const std::vector<BoxVerdict>& seeds,
                                                 const VotingParameters& parameters);

}  // namespace mapless
