#include <algorithm>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/row_votes.hpp"
#include "detection/witnesses.hpp"
#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

// Where each laser's returns begin, and where the last one's end.
std::vector<std::size_t> row_bounds(const LidarScan& scan) {
  std::vector<std::size_t> bounds;
  for (int l = 0; l <= scan.rows(); ++l) {
    const auto first = std::partition_point(scan.returns.begin(), scan.returns.end(),
                                            [l](const LidarReturn& r) { return r.laser < l; });
    bounds.push_back(static_cast<std::size_t>(first - scan.returns.begin()));
  }
  return bounds;
}

}  // namespace

LocalPoints local_points(const CompensatedScan& scan) {
  LocalPoints local;
  local.origin_0 =
      scan.column_T_0v.empty() ? Eigen::Vector3d::Zero() : scan.column_T_0v.front().translation();
  local.points.reserve(scan.points_0.size());
  for (const Eigen::Vector3d& p_0 : scan.points_0) {
    local.points.emplace_back((p_0 - local.origin_0).cast<float>());
  }
  return local;
}

int surface_votes(int gap) {
  int votes = 1;
  for (int reach = 4; reach <= gap && votes < kMostSurfaceVotes; reach *= 2) ++votes;
  return votes;
}

std::vector<PointVotes> collect_votes(const LidarScan& scan, const LocalPoints& points,
                                      const std::vector<AskedScan>& asked, const RayImage& own,
                                      const VotingParameters& parameters) {
  const Witnesses witnesses(scan, points, asked, own, parameters);
  std::vector<PointVotes> votes(points.points.size());
  const std::vector<std::size_t> bounds = row_bounds(scan);
  for (const RowVotes::Turn& turn : RowVotes::turns(scan.rows())) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, turn.rows.size(), 1), [&](const auto& part) {
      RowVotes row(scan, points, witnesses, parameters);
      for (std::size_t k = part.begin(); k != part.end(); ++k) {
        const auto l = static_cast<std::size_t>(turn.rows[k]);
        row.vote(turn.rows[k], turn.apart, bounds[l], bounds[l + 1], votes);
      }
    });
  }
  return votes;
}

}  // namespace mapless
