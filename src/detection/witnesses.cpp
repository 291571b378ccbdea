#include "detection/witnesses.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace mapless {
namespace {

// Votes against a point that settle it where the points asked with it have as many: of the order in_order
// gives, three scans, 32, 12 and 4 back.
constexpr int kEnough = 2 * kMostSurfaceVotes;

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

int recent_gap(const std::vector<AskedScan>& asked) {
  int nearest = std::numeric_limits<int>::max();
  for (const AskedScan& a : asked) nearest = std::min(nearest, std::abs(a.gap));
  return std::max(nearest, kRecentGap);
}

// Seen by scans enough, and by none seen through.
bool stands(const PointVotes& v) { return is_static(v) && v.total() <= -kEnough; }

}  // namespace

Witnesses::Witnesses(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
                     const RayImage& own, const VotingParameters& parameters)
    : scan_(scan),
      points_(points.points),
      vacated_m_(static_cast<float>(parameters.vacated_m)),
      own_(own, points.origin_0, parameters) {
  const int recent = recent_gap(asked);
  for (const AskedScan& a : in_order(asked)) {
    witnesses_.push_back({FreespaceProbe(*a.image, points.origin_0, parameters), surface_votes(a.gap),
                          a.gap < 0, std::abs(a.gap) <= recent});
  }
}

// One scan after another, so that what is known of it stays at hand.
void Witnesses::ask(const std::vector<std::size_t>& questions, Hearing& hearing,
                    std::vector<PointVotes>& votes) const {
  gather(questions, hearing);
  for (std::size_t k = 0; k < witnesses_.size() && !hearing.open.empty(); ++k) {
    hear_all(witnesses_[k], hearing);
    settle(k + 1, hearing);
  }
  for (const Four& four : hearing.fours) {
    for (std::size_t l = 0; l < four.count; ++l) votes[four.i[l]] = four.votes[l];
  }
}

void Witnesses::gather(const std::vector<std::size_t>& questions, Hearing& hearing) const {
  hearing.fours.clear();
  hearing.open.clear();
  for (std::size_t first = 0; first < questions.size(); first += 4) {
    Four four{};
    four.count = std::min<std::size_t>(4, questions.size() - first);
    for (std::size_t l = 0; l < 4; ++l) {
      four.i[l] = questions[first + std::min(l, four.count - 1)];
      four.q[l] = points_[four.i[l]];
    }
    hearing.open.push_back(hearing.fours.size());
    hearing.fours.push_back(four);
  }
}

// Consecutive firings look at consecutive columns of another scan too, so that the column one point was found
// in tells where to look for the next.
void Witnesses::hear_all(const Witness& witness, Hearing& hearing) const {
  float ahead = 0;  // of the point's own column
  const auto own_column = [&](std::size_t i) { return static_cast<float>(scan_.returns[i].column); };
  for (const std::size_t f : hearing.open) {
    Four& four = hearing.fours[f];
    std::array<float, 4> columns;
    for (std::size_t l = 0; l < 4; ++l) columns[l] = own_column(four.i[l]) + ahead;
    const auto answers = witness.probe.look(four.q, columns);
    ahead = columns[3] - own_column(four.i[3]);
    for (std::size_t l = 0; l < four.count; ++l) hear(four.i[l], witness, answers[l], four.votes[l]);
  }
}

// Fours of which all points stand are done: the scans from witness `next` on, which are not asked, are taken
// to see a surface as those before did.
void Witnesses::settle(std::size_t next, Hearing& hearing) const {
  std::erase_if(hearing.open, [&](std::size_t f) {
    Four& four = hearing.fours[f];
    if (!std::all_of(four.votes.begin(), four.votes.begin() + static_cast<std::ptrdiff_t>(four.count),
                     stands)) {
      return false;
    }
    for (PointVotes& v : four.votes) {
      for (std::size_t k = next; k < witnesses_.size(); ++k) {
        count(witnesses_[k], -witnesses_[k].surface_votes, v);
      }
    }
    return true;
  });
}

void Witnesses::count(const Witness& witness, int number, PointVotes& votes) {
  std::int16_t& sum = witness.later ? votes.later : votes.earlier;
  sum = static_cast<std::int16_t>(sum + number);
}

void Witnesses::hear(std::size_t i, const Witness& witness, const FreespaceProbe::Answer& answer,
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
bool Witnesses::has_left(std::size_t i, const Eigen::Vector3f& before) const {
  if ((before - points_[i]).squaredNorm() > vacated_m_ * vacated_m_) return false;
  auto column = static_cast<float>(scan_.returns[i].column);
  return own_.ask(before, column) == FreespaceVerdict::inside;
}

}  // namespace mapless
