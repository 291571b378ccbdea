#include <algorithm>

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

// Puts the points of one laser to all probes. A static surface is asked at every kStride-th point only: where
// two such points agree that nobody saw through them, so do the points between that lie on the line between
// them.
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const std::vector<FreespaceProbe>& probes,
           std::size_t earlier, float tolerance_m)
      : scan_(scan),
        points_(points.points),
        probes_(probes),
        earlier_(earlier),
        tolerance2_(tolerance_m * tolerance_m),
        columns_(probes.size()) {}

  void vote(std::size_t begin, std::size_t end, std::vector<PointVotes>& out) {
    if (begin == end) return;
    for (float& column : columns_) column = static_cast<float>(scan_.returns[begin].column);
    previous_column_ = scan_.returns[begin].column;
    out[begin] = ask(begin);
    for (std::size_t left = begin; left + 1 < end;) {
      const std::size_t right = std::min(left + kStride, end - 1);
      out[right] = ask(right);
      const bool settled = is_static(out[left]) && is_static(out[right]);
      for (std::size_t i = left + 1; i < right; ++i) {
        out[i] = settled && lies_between(i, left, right) ? out[left] : ask(i);
      }
      left = right;
    }
  }

 private:
  static constexpr std::size_t kStride = 4;

  static bool is_static(const PointVotes& v) { return v.surface_seen && !v.seen_through; }

  [[nodiscard]] bool lies_between(std::size_t i, std::size_t left, std::size_t right) const {
    const Eigen::Vector3f chord = points_[right] - points_[left];
    const Eigen::Vector3f d = points_[i] - points_[left];
    const float length2 = chord.squaredNorm();
    return (d * length2 - chord * chord.dot(d)).squaredNorm() <= tolerance2_ * length2 * length2;
  }

  // Consecutive firings look at consecutive columns of another scan too, so that the column one point was
  // found in tells where to look for the next.
  [[nodiscard]] PointVotes ask(std::size_t i) {
    const auto step = static_cast<float>(scan_.returns[i].column - previous_column_);
    previous_column_ = scan_.returns[i].column;
    PointVotes votes;
    for (std::size_t k = 0; k < probes_.size(); ++k) {
      columns_[k] += step;
      count(probes_[k].ask(points_[i], columns_[k]), k < earlier_ ? votes.earlier : votes.later, votes);
    }
    return votes;
  }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const std::vector<FreespaceProbe>& probes_;
  std::size_t earlier_;
  float tolerance2_;
  std::vector<float> columns_;  // where each probe found the last point
  int previous_column_ = 0;
};

// Where each laser's returns begin, and where the last one's end.
std::vector<std::size_t> row_bounds(const LidarScan& scan) {
  std::vector<std::size_t> bounds(static_cast<std::size_t>(scan.rows()) + 1, 0);
  for (const LidarReturn& r : scan.returns) ++bounds[static_cast<std::size_t>(r.laser) + 1];
  for (std::size_t l = 1; l < bounds.size(); ++l) bounds[l] += bounds[l - 1];
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

std::vector<PointVotes> collect_votes(const LidarScan& scan, const LocalPoints& points,
                                      const std::vector<const RayImage*>& earlier, const RayImage* later,
                                      const VotingParameters& parameters) {
  std::vector<FreespaceProbe> probes;
  for (const RayImage* image : earlier) probes.emplace_back(*image, points.origin_0, parameters);
  if (later != nullptr) probes.emplace_back(*later, points.origin_0, parameters);
  std::vector<PointVotes> votes(points.points.size());
  const std::vector<std::size_t> bounds = row_bounds(scan);
  const auto tolerance = static_cast<float>(parameters.tolerance_m) / 2;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bounds.size() - 1, 1), [&](const auto& rows) {
    RowVotes row(scan, points, probes, earlier.size(), tolerance);
    for (std::size_t l = rows.begin(); l != rows.end(); ++l) row.vote(bounds[l], bounds[l + 1], votes);
  });
  return votes;
}

}  // namespace mapless
