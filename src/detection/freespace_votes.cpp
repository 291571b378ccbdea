#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

// Votes against a point that settle it where the points asked with it have as many: of the order in_order
// gives, three scans, 32, 12 and 4 back.
constexpr int kEnough = 2 * kMostSurfaceVotes;

struct Witness {
  FreespaceProbe probe;
  int surface_votes;
  bool later;
  bool recent;
};

// The farthest first, and every third: those tell of seconds ago and of a moment ago. Where all of them saw a
// surface the others need not be asked.
std::vector<AskedScan> in_order(std::vector<AskedScan> asked) {
  std::stable_sort(asked.begin(), asked.end(),
                   [](const AskedScan& a, const AskedScan& b) { return std::abs(a.gap) > std::abs(b.gap); });
  std::vector<AskedScan> ordered;
  for (std::size_t first = 0; first < 3; ++first) {
    for (std::size_t k = first; k < asked.size(); k += 3) ordered.push_back(asked[k]);
  }
  return ordered;
}

bool is_static(const PointVotes& v) {
  return v.surface_seen && !v.seen_through && !v.vacated && !v.moving_seen;
}

bool same(const PointVotes& a, const PointVotes& b) {
  return a.earlier == b.earlier && a.later == b.later && a.seen_through == b.seen_through &&
         a.surface_seen == b.surface_seen && a.recently == b.recently && a.vacated == b.vacated &&
         a.moving_seen == b.moving_seen;
}

// Puts the points of one laser to all probes, one in kStride at first. Where two of them stand that nobody
// saw through, or have the same votes, so have the points between if all lie on the line between the two.
// Else the one half-way is asked, and so on. Questions go in fours (see FreespaceProbe::look).
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const std::vector<Witness>& witnesses,
           const FreespaceProbe& own, const VotingParameters& parameters)
      : scan_(scan),
        points_(points.points),
        witnesses_(witnesses),
        own_(own),
        tolerance2_(squared(parameters.tolerance_m / 2)),
        vacated_m_(static_cast<float>(parameters.vacated_m)),
        columns_(witnesses.size()) {}

  void vote(std::size_t begin, std::size_t end, std::vector<PointVotes>& out) {
    if (begin == end) return;
    begin_ = begin;
    out_ = out.data() + begin;
    for (std::vector<float>& columns : columns_) columns.resize(end - begin);
    ask_coarsely(end - begin);
    while (!open_.empty()) {
      questions_.clear();
      halves_.clear();
      for (const Span& span : open_) settle(span);
      for (std::size_t first = 0; first < questions_.size(); first += 4) ask_four(first);
      open_.swap(halves_);
    }
  }

 private:
  static constexpr std::size_t kStride = 64;
  static constexpr std::size_t kShort = 4;  // in a shorter span only the points off the line are asked

  // Points of the row, numbered from its first: two that were asked, and those between that were not.
  struct Span {
    std::size_t left, right;
  };

  // Consecutive firings look at consecutive columns of another scan too, so that the column one point was
  // found in tells where to look for the next.
  void ask_coarsely(std::size_t size) {
    questions_.clear();
    open_.clear();
    for (std::size_t i = 0; i + 1 < size; i += kStride) {
      questions_.push_back(i);
      open_.push_back({i, std::min(i + kStride, size - 1)});
    }
    questions_.push_back(size - 1);
    std::vector<float> ahead(witnesses_.size(), 0);  // of the point's own column
    for (std::size_t first = 0; first < questions_.size(); first += 4) {
      const std::size_t end = std::min(first + 4, questions_.size());
      const std::size_t last = questions_[end - 1];
      for (std::size_t k = 0; k < witnesses_.size(); ++k) {
        for (std::size_t n = first; n < end; ++n) {
          columns_[k][questions_[n]] = own_column(questions_[n]) + ahead[k];
        }
      }
      ask_four(first);
      for (std::size_t k = 0; k < witnesses_.size(); ++k) ahead[k] = columns_[k][last] - own_column(last);
    }
  }

  [[nodiscard]] float own_column(std::size_t i) const {
    return static_cast<float>(scan_.returns[begin_ + i].column);
  }

  // Gives the points between their votes, or leaves questions to be asked and spans to be settled then.
  void settle(const Span& span) {
    const auto [left, right] = span;
    if (right - left < 2) return;
    const bool agreed = (is_static(out_[left]) && is_static(out_[right])) || same(out_[left], out_[right]);
    if (agreed && (right - left <= kShort || all_on_line(span))) {
      for (std::size_t i = left + 1; i < right; ++i) {
        if (lies_on_line(i, span)) {
          out_[i] = out_[left];
        } else {
          question(i, span);
        }
      }
      return;
    }
    const std::size_t middle = (left + right) / 2;
    question(middle, span);
    halves_.push_back({left, middle});
    halves_.push_back({middle, right});
  }

  [[nodiscard]] bool all_on_line(const Span& span) const {
    for (std::size_t i = span.left + 1; i < span.right; ++i) {
      if (!lies_on_line(i, span)) return false;
    }
    return true;
  }

  [[nodiscard]] bool lies_on_line(std::size_t i, const Span& span) const {
    const Eigen::Vector3f& from = points_[begin_ + span.left];
    const Eigen::Vector3f chord = points_[begin_ + span.right] - from;
    const Eigen::Vector3f d = points_[begin_ + i] - from;
    const float length2 = chord.squaredNorm();
    return (d * length2 - chord * chord.dot(d)).squaredNorm() <= tolerance2_ * length2 * length2;
  }

  // Where the witnesses will find it lies between where they found the span's ends.
  void question(std::size_t i, const Span& span) {
    questions_.push_back(i);
    const auto share = static_cast<float>(i - span.left) / static_cast<float>(span.right - span.left);
    for (std::vector<float>& columns : columns_) {
      columns[i] = columns[span.left] + share * (columns[span.right] - columns[span.left]);
    }
  }

  // The four questions from `first` on, or those there are.
  void ask_four(std::size_t first) {
    const std::size_t count = std::min<std::size_t>(4, questions_.size() - first);
    std::array<std::size_t, 4> i{};
    std::array<Eigen::Vector3f, 4> q;
    for (std::size_t l = 0; l < 4; ++l) {
      i[l] = questions_[first + std::min(l, count - 1)];
      q[l] = points_[begin_ + i[l]];
    }
    std::array<PointVotes, 4> votes;
    for (std::size_t k = 0; k < witnesses_.size(); ++k) {
      if (std::all_of(votes.begin(), votes.begin() + static_cast<std::ptrdiff_t>(count), stands)) {
        for (PointVotes& v : votes) assume_seen(k, v);
        break;
      }
      std::vector<float>& found = columns_[k];
      std::array<float, 4> columns{found[i[0]], found[i[1]], found[i[2]], found[i[3]]};
      const auto answers = witnesses_[k].probe.look(q, columns);
      for (std::size_t l = 0; l < count; ++l) {
        found[i[l]] = columns[l];
        hear(begin_ + i[l], witnesses_[k], answers[l], votes[l]);
      }
    }
    for (std::size_t l = 0; l < count; ++l) out_[i[l]] = votes[l];
  }

  // Seen by scans enough, and by none seen through.
  static bool stands(const PointVotes& v) { return is_static(v) && v.total() <= -kEnough; }

  // The scans from witness k on, which are not asked, are taken to see a surface as those before did.
  void assume_seen(std::size_t k, PointVotes& votes) const {
    for (; k < witnesses_.size(); ++k) {
      count(witnesses_[k], -witnesses_[k].surface_votes, votes);
    }
  }

  static void count(const Witness& witness, int number, PointVotes& votes) {
    std::int16_t& sum = witness.later ? votes.later : votes.earlier;
    sum = static_cast<std::int16_t>(sum + number);
  }

  void hear(std::size_t i, const Witness& witness, const FreespaceProbe::Answer& answer,
            PointVotes& votes) const {
    if (answer.verdict == FreespaceVerdict::inside) {
      count(witness, kSeenThroughVotes, votes);
      votes.seen_through = true;
      votes.recently = votes.recently || witness.recent;
    } else if (answer.verdict == FreespaceVerdict::border) {
      const bool moving = witness.recent && witness.probe.dynamic(answer);
      count(witness, moving ? kMovingVotes : -witness.surface_votes, votes);
      votes.moving_seen = votes.moving_seen || moving;
      votes.surface_seen = true;
    } else if (answer.verdict == FreespaceVerdict::outside && answer.short_by_m <= vacated_m_ &&
               witness.probe.ended(answer) &&
               has_left(i, witness.probe.endpoint(answer.laser, answer.column))) {
      count(witness, kVacatedVotes, votes);
      votes.vacated = true;
      votes.recently = votes.recently || witness.recent;
    }
  }

  // Whether what stood at `before` and hid point i is near enough to be the same thing, and not there now.
  [[nodiscard]] bool has_left(std::size_t i, const Eigen::Vector3f& before) const {
    if ((before - points_[i]).squaredNorm() > vacated_m_ * vacated_m_) return false;
    auto column = static_cast<float>(scan_.returns[i].column);
    return own_.ask(before, column) == FreespaceVerdict::inside;
  }

  static float squared(double x) { return static_cast<float>(x * x); }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const std::vector<Witness>& witnesses_;
  const FreespaceProbe& own_;
  float tolerance2_, vacated_m_;
  // Of one row:
  std::size_t begin_ = 0;                    // its first point
  PointVotes* out_ = nullptr;                // of its points
  std::vector<std::vector<float>> columns_;  // where each witness found, or is to look for, each point
  std::vector<std::size_t> questions_;
  std::vector<Span> open_, halves_;
};

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
  for (const AskedScan& a : in_order(asked)) {
    witnesses.push_back({FreespaceProbe(*a.image, points.origin_0, parameters), surface_votes(a.gap),
                         a.gap < 0, std::abs(a.gap) <= recent});
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
