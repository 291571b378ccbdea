#include <algorithm>
#include <cstdlib>
#include <limits>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

struct Witness {
  FreespaceProbe probe;
  int gap;
  bool recent;
};

// Puts the points of one laser to all probes. A static surface is asked at every kStride-th point only: where
// two such points agree that nobody saw through them, so do the points between that lie on the line between
// them.
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const std::vector<Witness>& witnesses,
           const FreespaceProbe& own, const VotingParameters& parameters)
      : scan_(scan),
        points_(points.points),
        witnesses_(witnesses),
        own_(own),
        tolerance2_(squared(parameters.tolerance_m / 2)),
        vacated2_(squared(parameters.vacated_m)),
        columns_(witnesses.size()) {}

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

  static bool is_static(const PointVotes& v) { return v.surface_seen && !v.seen_through && !v.vacated; }

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
    for (std::size_t k = 0; k < witnesses_.size(); ++k) {
      columns_[k] += step;
      hear(i, witnesses_[k], columns_[k], votes);
    }
    return votes;
  }

  void hear(std::size_t i, const Witness& witness, float& column, PointVotes& votes) const {
    const auto answer = witness.probe.look(points_[i], column);
    int count = 0;
    if (answer.verdict == FreespaceVerdict::inside) {
      count = kSeenThroughVotes;
      votes.seen_through = true;
    } else if (answer.verdict == FreespaceVerdict::border) {
      count = -surface_votes(witness.gap);
      votes.surface_seen = true;
    } else if (answer.verdict == FreespaceVerdict::outside && witness.probe.ended(answer) &&
               has_left(i, witness.probe.endpoint(answer.laser, answer.column))) {
      count = kVacatedVotes;
      votes.vacated = true;
    }
    std::int16_t& sum = witness.gap < 0 ? votes.later : votes.earlier;
    sum = static_cast<std::int16_t>(sum + count);
    votes.recently = votes.recently || (count > 0 && witness.recent);
  }

  // Whether what stood at `before` and hid point i is near enough to be the same thing, and not there now.
  [[nodiscard]] bool has_left(std::size_t i, const Eigen::Vector3f& before) const {
    if ((before - points_[i]).squaredNorm() > vacated2_) return false;
    auto column = static_cast<float>(scan_.returns[i].column);
    return own_.ask(before, column) == FreespaceVerdict::inside;
  }

  static float squared(double x) { return static_cast<float>(x * x); }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const std::vector<Witness>& witnesses_;
  const FreespaceProbe& own_;
  float tolerance2_, vacated2_;
  std::vector<float> columns_;  // where each witness found the last point
  int previous_column_ = 0;
};

// Where each laser's returns begin, and where the last one's end.
std::vector<std::size_t> row_bounds(const LidarScan& scan) {
  std::vector<std::size_t> bounds(static_cast<std::size_t>(scan.rows()) + 1, 0);
  for (const LidarReturn& r : scan.returns) ++bounds[static_cast<std::size_t>(r.laser) + 1];
  for (std::size_t l = 1; l < bounds.size(); ++l) bounds[l] += bounds[l - 1];
  return bounds;
}

int recent_gap(const std::vector<AskedScan>& asked) {
  int nearest = std::numeric_limits<int>::max();
  for (const AskedScan& a : asked) nearest = std::min(nearest, std::abs(a.gap));
  return std::max(nearest, kRecentGap);
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
  const int recent = recent_gap(asked);
  std::vector<Witness> witnesses;
  for (const AskedScan& a : asked) {
    witnesses.push_back(
        {FreespaceProbe(*a.image, points.origin_0, parameters), a.gap, std::abs(a.gap) <= recent});
  }
  const FreespaceProbe own_probe(own, points.origin_0, parameters);
  std::vector<PointVotes> votes(points.points.size());
  const std::vector<std::size_t> bounds = row_bounds(scan);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bounds.size() - 1, 1), [&](const auto& rows) {
    RowVotes row(scan, points, witnesses, own_probe, parameters);
    for (std::size_t l = rows.begin(); l != rows.end(); ++l) row.vote(bounds[l], bounds[l + 1], votes);
  });
  return votes;
}

}  // namespace mapless
