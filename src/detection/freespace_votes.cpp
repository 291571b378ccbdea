#include <numbers>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

void count(FreespaceVerdict verdict, std::int8_t& votes, PointVotes& point) {
  if (verdict == FreespaceVerdict::inside) {
    ++votes;
    point.seen_through = true;
  } else if (verdict == FreespaceVerdict::border) {
    --votes;
    point.surface_seen = true;
  }
}

// Returns come laser by laser, column after column: the column one point was found in is the best guess for
// the next. The first of each chunk starts from its own column, so that chunks do not depend on another.
void ask_chunk(const LidarScan& scan, const LocalPoints& points, const FreespaceProbe& probe,
               std::size_t begin, std::size_t end, std::int8_t PointVotes::*votes,
               std::vector<PointVotes>& out) {
  int laser = -1;
  float column = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const LidarReturn& r = scan.returns[i];
    if (r.laser != laser) column = static_cast<float>(r.column);
    laser = r.laser;
    count(probe.ask(points.points[i], column), out[i].*votes, out[i]);
  }
}

}  // namespace

LocalPoints local_points(const CompensatedScan& scan) {
  LocalPoints local;
  local.origin_0 = scan.column_T_0v.empty() ? Eigen::Vector3d::Zero() : scan.column_T_0v.front().translation();
  local.points.reserve(scan.points_0.size());
  for (const Eigen::Vector3d& p_0 : scan.points_0) {
    local.points.emplace_back((p_0 - local.origin_0).cast<float>());
  }
  return local;
}

std::vector<PointVotes> collect_votes(const LidarScan& scan, const LocalPoints& points,
                                      const std::vector<const RayImage*>& earlier, const RayImage* later,
                                      const VotingParameters& parameters) {
  std::vector<FreespaceProbe> probes;
  for (const RayImage* image : earlier) probes.emplace_back(*image, points.origin_0, parameters);
  if (later != nullptr) probes.emplace_back(*later, points.origin_0, parameters);
  std::vector<PointVotes> votes(points.points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, votes.size(), 2048), [&](const auto& chunk) {
    for (std::size_t k = 0; k < probes.size(); ++k) {
      ask_chunk(scan, points, probes[k], chunk.begin(), chunk.end(),
                k < earlier.size() ? &PointVotes::earlier : &PointVotes::later, votes);
    }
  });
  return votes;
}

}  // namespace mapless
