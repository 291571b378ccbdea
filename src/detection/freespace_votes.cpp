#include <algorithm>
#include <functional>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
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
  // Every second row and the last one, then those between.
  const int last = scan.rows() - 1;
  tbb::enumerable_thread_specific<RowVotes> of_thread(std::cref(scan), std::cref(points),
                                                      std::cref(witnesses));
  for (const bool between : {false, true}) {
    tbb::parallel_for(tbb::blocked_range<int>(0, scan.rows(), 1), [&](const auto& part) {
      RowVotes& row = of_thread.local();
      for (int l = part.begin(); l != part.end(); ++l) {
        if (between != (l % 2 == 1 && l != last)) continue;
        const auto k = static_cast<std::size_t>(l);
        row.vote(l, between, bounds[k], bounds[k + 1], votes);
      }
    });
  }
  return votes;
}

}  // namespace mapless
