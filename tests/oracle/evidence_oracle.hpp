#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "detection/evidence/evidence_collector.hpp"

namespace mapless::test {

/// The evidence of every point, queried alone, by the rules of point_evidence.hpp and evidence_collector.hpp;
/// but for returns that were found dynamic, of which there are none.
inline std::vector<PointEvidence> query_every_point(const LidarScan& scan, const LocalPoints& points,
                                                    const std::vector<ReferenceScan>& references,
                                                    const RayImage& own, const VotingParameters& parameters) {
  std::vector<PointEvidence> evidence(points.points.size());
  const SlopeImage slopes(scan, points.points);
  const FreespaceProbe own_probe(own, points.origin_0, parameters);
  const auto seen_next = [&](const Eigen::Vector3f& now) {
    return std::any_of(references.begin(), references.end(), [&](const ReferenceScan& a) {
      float column = 0;
      return a.gap < 0 && FreespaceProbe(*a.image, points.origin_0, parameters).verdict(now, column) ==
                              FreespaceVerdict::border;
    });
  };
  const auto has_left = [&](const Eigen::Vector3f& then, std::size_t i, int gap) {
    const Eigen::Vector3f& now = points.points[i];
    const LidarReturn& r = scan.returns[i];
    const float off_m = (then - now).norm();
    float column = 0;
    if (off_m > static_cast<float>(parameters.max_occluder_distance_m) ||
        own_probe.verdict(then, column) != FreespaceVerdict::inside)
      return false;
    return gap < 0 || off_m / static_cast<float>(gap) <= 2 * own_probe.tolerance_m(r.laser, r.range_m) ||
           !seen_next(now);
  };
  for (const ReferenceScan& a : references) {
    const FreespaceProbe probe(*a.image, points.origin_0, parameters);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      float column = 0;
      const auto answer = probe.observe(points.points[i], column, slopes.of(i, 1));
      int vote = 0;
      const bool inside = answer.verdict == FreespaceVerdict::inside;
      if (inside) vote = answer.aside_m <= 0.07F || !probe.ended(answer) ? 4 : 2;
      if (answer.verdict == FreespaceVerdict::border) vote = -surface_votes(a.gap);
      if (answer.verdict == FreespaceVerdict::outside &&
          has_left(probe.endpoint(answer.laser, answer.column), i, a.gap))
        vote = 2;
      auto& sum = a.gap > 0 ? evidence[i].past : evidence[i].future;
      sum = static_cast<std::int16_t>(sum + vote);
      evidence[i].seen_through = evidence[i].seen_through || inside;
      evidence[i].occluder_left = evidence[i].occluder_left || (vote == 2 && !inside);
      evidence[i].surface_seen = evidence[i].surface_seen || vote < 0;
      evidence[i].stood_before = evidence[i].stood_before || (vote < 0 && std::abs(a.gap) > 4);
      evidence[i].surface_last = evidence[i].surface_last || (vote < 0 && a.gap == 1);
      evidence[i].surface_next = evidence[i].surface_next || (vote < 0 && a.gap == -1);
      evidence[i].recently_free = evidence[i].recently_free || (vote > 0 && std::abs(a.gap) <= 4);
    }
  }
  return evidence;
}

}  // namespace mapless::test
