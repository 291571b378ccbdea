#include "detection/evidence/evidence_collector.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>

#include "detection/freespace/range_noise.hpp"

namespace mapless::inline v1 {
namespace {

// Votes against a point that settle it, if no scan saw through: of the order in_order gives, three scans, 32,
// 12 and 4 back.
constexpr int kEnough = 9;
// Fewer, once so many scans were asked: of a point that some could not see and the others saw a surface at,
// those left say the same.
constexpr std::size_t kManyAsked = 6;
constexpr int kEnoughOfMany = 6;

// Two standard deviations of the difference between two ranges, as a share of the tolerance, which is
// kToleratedDeviations of one range.
constexpr double kSurfaceNoise = 2 * std::numbers::sqrt2 / kToleratedDeviations;

// What stood for so many scans stands: those before are asked where that is not settled. A sensor that moves
// has rarely seen a place then.
constexpr int kLongAgo = 32;

// The farthest of no longer ago first, and every third: those tell of seconds ago and of a moment ago. Where
// all of them saw a surface the others need not be asked.
std::vector<AskedScan> in_order(std::vector<AskedScan> asked) {
  std::stable_sort(asked.begin(), asked.end(),
                   [](const AskedScan& a, const AskedScan& b) { return std::abs(a.gap) > std::abs(b.gap); });
  const auto lately =
      std::stable_partition(asked.begin(), asked.end(), [](const AskedScan& a) { return a.gap > kLongAgo; });
  const std::span recent(lately, asked.end());
  std::vector<AskedScan> ordered;
  ordered.reserve(asked.size());
  for (std::size_t first = 0; first < 3; ++first) {
    for (std::size_t k = first; k < recent.size(); k += 3) ordered.push_back(recent[k]);
  }
  ordered.insert(ordered.end(), asked.begin(), lately);
  return ordered;
}

int recent_gap(const std::vector<AskedScan>& asked) {
  int nearest = std::numeric_limits<int>::max();
  for (const AskedScan& a : asked) nearest = std::min(nearest, std::abs(a.gap));
  return std::max(nearest, kRecentGap);
}

// Of the nearest later scan, 0 where there is none.
int next_gap(const std::vector<AskedScan>& asked) {
  int next = 0;
  for (const AskedScan& a : asked) {
    if (a.gap < 0 && (next == 0 || a.gap > next)) next = a.gap;
  }
  return next;
}

}  // namespace

Witnesses::Witnesses(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
                     const RayImage& own, const VotingParameters& parameters)
    : scan_(scan),
      points_(points.points),
      vacated_m_(static_cast<float>(parameters.vacated_m)),
      surface_noise_m_(static_cast<float>(kSurfaceNoise * parameters.tolerance_m)),
      own_(own, points.origin_0, parameters) {
  const int recent = recent_gap(asked), next = next_gap(asked);
  witnesses_.reserve(asked.size());
  for (const AskedScan& a : in_order(asked)) {
    witnesses_.push_back({FreespaceProbe(*a.image, points.origin_0, parameters),
                          surface_votes(std::abs(a.gap)), a.gap < 0, a.gap == next, std::abs(a.gap) <= recent,
                          std::abs(a.gap)});
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
  count_leavers(hearing);
  for (const Question& question : hearing.questions) votes[question.i] = question.votes;
}

void Witnesses::gather(const std::vector<std::size_t>& questions, Hearing& hearing) const {
  hearing.questions.clear();
  hearing.open.clear();
  hearing.leavers.clear();
  hearing.points.clear();
  for (const std::size_t i : questions) {
    hearing.open.push_back(hearing.questions.size());
    hearing.questions.push_back({static_cast<std::uint32_t>(i), {}});
    hearing.points.add(points_[i], column(i));
  }
}

void Witnesses::hear_all(const Witness& witness, Hearing& hearing) const {
  hearing.hiders.clear();
  hearing.points.look(witness.probe, [&](std::size_t k, const FreespaceProbe::Answer& answer) {
    hear(witness, answer, hearing.questions[hearing.open[k]], hearing);
  });
  ask_whether_left(witness, hearing);
}

// The scans from witness `next` on, which are not asked, are taken to see a surface as those before did.
void Witnesses::settle(std::size_t next, Hearing& hearing) const {
  int most = 0;
  for (std::size_t k = 0; k < next; ++k) most += witnesses_[k].surface_votes;
  const int enough = next < kManyAsked ? kEnough : kEnoughOfMany;
  if (most < enough) return;
  std::size_t still_open = 0;
  for (std::size_t n = 0; n < hearing.open.size(); ++n) {
    Question& question = hearing.questions[hearing.open[n]];
    PointVotes& votes = question.votes;
    if (is_static(votes) && votes.total() <= -enough && !question.hider_left) {
      for (std::size_t k = next; k < witnesses_.size(); ++k)
        count(witnesses_[k], -witnesses_[k].surface_votes, votes);
      continue;
    }
    if (still_open != n) {
      hearing.open[still_open] = hearing.open[n];
      hearing.points.move(n, still_open);
    }
    ++still_open;
  }
  hearing.open.resize(still_open);
  hearing.points.shrink(still_open);
}

void Witnesses::count(const Witness& witness, int number, PointVotes& votes) {
  std::int16_t& sum = witness.later ? votes.later : votes.earlier;
  sum = static_cast<std::int16_t>(sum + number);
}

void Witnesses::hear(const Witness& witness, const FreespaceProbe::Answer& answer, Question& question,
                     Hearing& hearing) const {
  PointVotes& votes = question.votes;
  if (answer.verdict == FreespaceVerdict::inside) {
    const bool through = answer.aside_m <= kThroughItself_m || !witness.probe.ended(answer);
    count(witness, through ? kSeenThroughVotes : kSeenPastVotes, votes);
    votes.seen_through = true;
    votes.recently = votes.recently || witness.recent;
  } else if (answer.verdict == FreespaceVerdict::border) {
    const bool moved = witness.probe.dynamic(answer);
    if (!moved) count(witness, -witness.surface_votes, votes);
    if (moved && witness.recent) count(witness, kMovingVotes, votes);
    votes.moving_seen = votes.moving_seen || (moved && witness.recent);
    votes.surface_seen = true;
    question.seen_next = question.seen_next || witness.next;
    if (witness.next) question.next_off_m = std::abs(answer.short_by_m);
  } else if (answer.verdict == FreespaceVerdict::outside && answer.short_by_m <= vacated_m_ &&
             witness.probe.ended(answer) && witness.later == witness.next) {
    witness.probe.prepare_endpoint(answer.column);
    hearing.hiders.push_back({&question, answer.laser, answer.column});
  }
}

// Whether what hid a point, near enough to be the same thing, is not there now.
void Witnesses::ask_whether_left(const Witness& witness, Hearing& hearing) const {
  hearing.places.clear();
  std::erase_if(hearing.hiders, [&](Hearing::Hider& hider) {
    const Eigen::Vector3f place = witness.probe.endpoint(hider.laser, hider.column);
    const std::size_t i = hider.question->i;
    hider.distance2_m2 = (place - points_[i]).squaredNorm();
    if (hider.distance2_m2 > vacated_m_ * vacated_m_) return true;
    hearing.places.add(place, column(i));
    return false;
  });
  hearing.places.look(own_, [&](std::size_t k, const FreespaceProbe::Answer& answer) {
    if (answer.verdict != FreespaceVerdict::inside) return;
    const Hearing::Hider& hider = hearing.hiders[k];
    hider.question->hider_left = true;
    hearing.leavers.push_back({hider.question, &witness, std::sqrt(hider.distance2_m2)});
  });
}

void Witnesses::count_leavers(Hearing& hearing) const {
  for (const Hearing::Leaver& leaver : hearing.leavers) {
    if (!goes_on(leaver)) continue;
    PointVotes& votes = leaver.question->votes;
    count(*leaver.witness, kVacatedVotes, votes);
    votes.vacated = true;
    votes.recently = votes.recently || leaver.witness->recent;
  }
}

// Whether the point may be of what left: that goes on, and where it clearly does the later scan finds no
// surface at the point, or finds it farther off by much of what it went.
bool Witnesses::goes_on(const Hearing::Leaver& leaver) const {
  if (leaver.witness->later || !leaver.question->seen_next) return true;
  const LidarReturn& r = scan_.returns[leaver.question->i];
  const float advance_m = leaver.distance_m / static_cast<float>(leaver.witness->scans_off);
  // The first of the two where the second is not a number: that surface was beside the firing.
  const float at_rest_m = std::min(kClearlyGone * own_.tolerance_m(r.laser, r.range_m),
                                   surface_noise_m_ + kClearlyGone * leaver.question->next_off_m);
  return advance_m <= at_rest_m;
}

}  // namespace mapless
