#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "detection/evidence/point_evidence.hpp"

namespace mapless::test {

/// Every point by itself, from the rules in freespace_votes.hpp.
inline std::vector<PointVotes> ask_every_point(const LidarScan& scan, const LocalPoints& points,
                                               const std::vector<AskedScan>& asked, const RayImage& own,
                                               const VotingParameters& parameters) {
  std::vector<PointVotes> votes(points.points.size());
  const FreespaceProbe own_probe(own, points.origin_0, parameters);
  const auto seen_next = [&](const Eigen::Vector3f& now) {
    return std::any_of(asked.begin(), asked.end(), [&](const AskedScan& a) {
      float column = 0;
      return a.gap < 0 && FreespaceProbe(*a.image, points.origin_0, parameters).ask(now, column) ==
                              FreespaceVerdict::border;
    });
  };
  const auto has_left = [&](const Eigen::Vector3f& then, std::size_t i, int gap) {
    const Eigen::Vector3f& now = points.points[i];
    const LidarReturn& r = scan.returns[i];
    const float off_m = (then - now).norm();
    float column = 0;
    if (off_m > static_cast<float>(parameters.vacated_m) ||
        own_probe.ask(then, column) != FreespaceVerdict::inside)
      return false;
    return gap < 0 || off_m / static_cast<float>(gap) <= 2 * own_probe.tolerance_m(r.laser, r.range_m) ||
           !seen_next(now);
  };
  for (const AskedScan& a : asked) {
    const FreespaceProbe probe(*a.image, points.origin_0, parameters);
    for (std::size_t i = 0; i < votes.size(); ++i) {
      float column = 0;
      const auto answer = probe.look(points.points[i], column);
      int vote = 0;
      const bool inside = answer.verdict == FreespaceVerdict::inside;
      if (inside) vote = answer.aside_m <= 0.07F || !probe.ended(answer) ? 4 : 2;
      if (answer.verdict == FreespaceVerdict::border) vote = -surface_votes(a.gap);
      if (answer.verdict == FreespaceVerdict::outside &&
          has_left(probe.endpoint(answer.laser, answer.column), i, a.gap))
        vote = 2;
      auto& sum = a.gap > 0 ? votes[i].earlier : votes[i].later;
      sum = static_cast<std::int16_t>(sum + vote);
      votes[i].seen_through = votes[i].seen_through || inside;
      votes[i].vacated = votes[i].vacated || (vote == 2 && !inside);
      votes[i].surface_seen = votes[i].surface_seen || vote < 0;
      votes[i].recently = votes[i].recently || (vote > 0 && std::abs(a.gap) <= 4);
    }
  }
  return votes;
}

}  // namespace mapless::test
