#include "detection/evidence/point_evidence.hpp"

#include <algorithm>
#include <functional>
#include <span>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/evidence/evidence_collector.hpp"
#include "detection/evidence/scanline_sampler.hpp"

namespace mapless::inline v1 {
namespace {

// More stay longer with what is known of one scan; fewer are more to share among threads.
constexpr std::size_t kMostRowsAtOnce = 9;

// Every second row and the last one, or those between.
std::vector<RowVotes::Row> rows_of(const LidarScan& scan, bool between) {
  const int last = scan.rows() - 1;
  std::vector<RowVotes::Row> rows;
  rows.reserve(scan.model->lasers.size());
  auto begin = scan.returns.begin();
  for (int l = 0; l <= last; ++l) {
    const auto end =
        std::partition_point(begin, scan.returns.end(), [l](const LidarReturn& r) { return r.laser <= l; });
    if (between == (l % 2 == 1 && l != last)) {
      rows.push_back({static_cast<std::size_t>(begin - scan.returns.begin()),
                      static_cast<std::size_t>(end - scan.returns.begin())});
    }
    begin = end;
  }
  return rows;
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
  tbb::enumerable_thread_specific<RowVotes> of_thread(std::cref(scan), std::cref(points),
                                                      std::cref(witnesses));
  for (const bool between : {false, true}) {
    const std::vector<RowVotes::Row> rows = rows_of(scan, between);
    const std::size_t parts = (rows.size() + kMostRowsAtOnce - 1) / kMostRowsAtOnce;
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
      const std::size_t first = part * rows.size() / parts, end = (part + 1) * rows.size() / parts;
      of_thread.local().vote(std::span(rows).subspan(first, end - first), between, votes);
    });
  }
  return votes;
}

}  // namespace mapless
