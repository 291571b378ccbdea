#include "detection/segmentation/explain_segmentation.hpp"

#include <oneapi/tbb/parallel_for.h>

#include "detection/segmentation/linked_neighbours.hpp"

namespace mapless::inline v1 {

void explain_segmentation(const LidarScan& scan, const LocalPoints& points,
                          const std::vector<PointEvidence>& votes, const EvidenceGrowthResult& regions,
                          const VotingParameters& parameters, ScanExplanation& explanation) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  explanation.limits.fill_neighbours = kFillNeighbours;
  explanation.limits.firmly_static_votes = kFirmlyStatic;
  explanation.points.resize(votes.size());
  tbb::parallel_for(std::size_t{0}, votes.size(), [&](std::size_t i) {
    const PointEvidence& v = votes[i];
    PointDecision& out = explanation.points[i];
    out.past = v.past;
    out.future = v.future;
    out.seen_through = v.seen_through;
    out.surface_seen = v.surface_seen;
    out.occluder_left = v.occluder_left;
    out.may_be_slow = v.may_be_slow;
    out.proposed = regions.object[i];
    out.growth = regions.verdict[i];
    int support = v.total();
    const auto at = static_cast<std::int32_t>(i);
    neighbours.for_each(at, kSupportRows, kSupportColumns, [&](std::int32_t j) {
      support += votes[static_cast<std::size_t>(j)].total();
      ++out.supporters;
      if (regions.object[static_cast<std::size_t>(j)] != 0) ++out.near_labelled;
    });
    out.support = static_cast<std::int16_t>(support);
    neighbours.for_each(at, kLinkRows, kLinkColumns, [&](std::int32_t j) {
      if (regions.object[static_cast<std::size_t>(j)] != 0) ++out.reach_labelled;
    });
  });
  for (const std::int32_t i : regions.rims) explanation.points[static_cast<std::size_t>(i)].proposed = 0;
}

}  // namespace mapless
