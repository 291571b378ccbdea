#include "detection/segmentation/slow_surfaces.hpp"

#include <cstddef>
#include <cstdint>

#include <oneapi/tbb/parallel_for.h>

#include "detection/segmentation/linked_neighbours.hpp"

namespace mapless::inline v1 {
namespace {

bool was_free(const PointEvidence& v) { return v.seen_through || v.occluder_left; }

bool may_be_slow(const LinkedNeighbours& neighbours, const std::vector<PointEvidence>& votes, std::size_t i) {
  const PointEvidence& v = votes[i];
  if (v.stood_before || !(v.surface_last || v.surface_next)) return false;
  bool any_free = was_free(v);
  if (!any_free) {
    neighbours.for_each(static_cast<std::int32_t>(i), kSupportRows, kSupportColumns, [&](std::int32_t j) {
      any_free = any_free || was_free(votes[static_cast<std::size_t>(j)]);
    });
  }
  return any_free;
}

}  // namespace

void forgive_slow_surfaces(const LidarScan& scan, const LocalPoints& points,
                           const VotingParameters& parameters, std::vector<PointEvidence>& votes) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  std::vector<std::uint8_t> slow(votes.size(), 0);  // as the bits of one PointEvidence share a byte
  tbb::parallel_for(std::size_t{0}, votes.size(),
                    [&](std::size_t i) { slow[i] = may_be_slow(neighbours, votes, i) ? 1 : 0; });
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (slow[i] == 0) continue;
    PointEvidence& v = votes[i];
    v.may_be_slow = true;
    v.past = static_cast<std::int16_t>(v.past + (v.surface_last ? surface_votes(1) : 0));
    v.future = static_cast<std::int16_t>(v.future + (v.surface_next ? surface_votes(-1) : 0));
  }
}

}  // namespace mapless
