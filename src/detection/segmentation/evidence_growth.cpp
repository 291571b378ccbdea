#include "detection/segmentation/evidence_growth.hpp"

#include <algorithm>
#include <span>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/object_number.hpp"
#include "detection/segmentation/linked_neighbours.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include "detection/segmentation/tangential_surfaces.hpp"

namespace mapless::inline v1 {
namespace {

// Holes are filled where more than a third of the support window is dynamic: twice whatever is not firmly
// static, and on where no scan but those of a moment ago saw a surface, as sliding sides look.
constexpr int kFillNeighbours = 5, kFillRounds = 2, kSlidingRounds = 6;

// Neither fill nor growth reaches points against which there are more votes than three scans that see through
// would make good.
constexpr int kFirmlyStatic = -3 * kSeenThroughVotes;

constexpr std::size_t kManyCandidates = 8192;  // room for so many is made at once

class EvidenceGrowth {
  using Of = LinkedNeighbours::Of;

 public:
  EvidenceGrowth(const LidarScan& scan, const LinkedNeighbours& neighbours, const LocalPoints& points,
                 const std::vector<PointVotes>& votes, const VotingParameters& parameters)
      : scan_(scan),
        neighbours_(neighbours),
        points_(points),
        votes_(votes),
        parameters_(parameters),
        marks_(scan, neighbours.image()) {
    result_.verdict.assign(votes.size(), GrowthVerdict::not_reached);
    result_.object.assign(votes.size(), 0);
  }

  EvidenceGrowthResult grow(const std::vector<BoxVerdict>& seeds) {
    collect_candidates(seeds);
    keep_large_clusters(seeds);
    if (parameters_.grow) spread();
    mark_dynamic();
    if (parameters_.grow) fill();
    number_objects();
    if (parameters_.grow && something_stands() && slide()) number_objects();
    weigh_objects();
    return std::move(result_);
  }

 private:
  GrowthVerdict& verdict(std::int32_t i) { return result_.verdict[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool dynamic(std::int32_t i) {
    return verdict(i) == GrowthVerdict::seed || verdict(i) == GrowthVerdict::grown;
  }

  // What was uncovered beside a thing that moved looks as if that had left it too: alone that is not enough.
  [[nodiscard]] bool may_move(std::int32_t i) const {
    const PointVotes& v = votes_[static_cast<std::size_t>(i)];
    return v.total() > 0 || (v.seen_through && v.total() >= kFirmlyStatic);
  }

  // The few that can be more than filled in.
  void collect_candidates(const std::vector<BoxVerdict>& seeds) {
    candidates_.reserve(kManyCandidates);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(votes_.size()); ++i) {
      const auto n = static_cast<std::size_t>(i);
      if (votes_[n].total() > 0 || votes_[n].seen_through || seeds[n] == BoxVerdict::kept)
        candidates_.push_back(i);
    }
    for (auto* some : {&front_, &dynamic_, &objects_}) some->reserve(candidates_.size());
  }

  // Everything marked and linked to `first`, in front_, marked no more.
  void collect(std::int32_t first) {
    front_.assign(1, first);
    marks_.unmark(first);
    for (std::size_t next = 0; next < front_.size(); ++next) {
      neighbours_.for_each<Of::marked>(front_[next], kLinkRows, kLinkColumns, marks_, [&](std::int32_t j) {
        marks_.unmark(j);
        front_.push_back(j);
      });
    }
  }

  void keep_large_clusters(const std::vector<BoxVerdict>& seeds) {
    const auto is_kept = [&](std::int32_t i) {
      return seeds[static_cast<std::size_t>(i)] == BoxVerdict::kept;
    };
    for (const std::int32_t i : candidates_) {
      if (is_kept(i)) marks_.mark(i);
    }
    for (const std::int32_t i : candidates_) {
      if (!is_kept(i) || verdict(i) != GrowthVerdict::not_reached) continue;
      collect(i);
      const bool large = static_cast<int>(front_.size()) >= parameters_.min_seeds;
      for (const std::int32_t j : front_) verdict(j) = large ? GrowthVerdict::seed : GrowthVerdict::too_small;
    }
  }

  void spread() {
    marks_.clear();
    front_.clear();
    for (const std::int32_t i : candidates_) {
      if (verdict(i) == GrowthVerdict::seed) {
        front_.push_back(i);
      } else if (may_move(i)) {
        marks_.mark(i);
      }
    }
    while (!front_.empty()) {
      const std::int32_t i = front_.back();
      front_.pop_back();
      neighbours_.for_each<Of::marked>(i, kLinkRows, kLinkColumns, marks_, [&](std::int32_t j) {
        verdict(j) = GrowthVerdict::grown;
        marks_.unmark(j);
        front_.push_back(j);
      });
    }
  }

  void mark_dynamic() {
    marks_.clear();
    for (const std::int32_t i : candidates_) {
      if (!dynamic(i)) continue;
      marks_.mark(i);
      dynamic_.push_back(i);
    }
  }

  // Holes and rims: what no scan could look at, or few saw a surface at, moves with what surrounds it. The
  // marks are on what moves.
  void fill() {
    std::vector<std::int8_t> dynamic_neighbours(votes_.size(), 0);
    std::vector<std::int32_t> added = dynamic_;
    for (int round = 0; round < kFillRounds + kSlidingRounds && !added.empty(); ++round) {
      count_beside(added, round < kFillRounds ? kFirmlyStatic : kSliding, dynamic_neighbours);
      for (const std::int32_t i : front_) {
        verdict(i) = GrowthVerdict::grown;
        marks_.mark(i);
      }
      dynamic_.insert(dynamic_.end(), front_.begin(), front_.end());
      added.swap(front_);
    }
    std::sort(dynamic_.begin(), dynamic_.end());
  }

  // In the first scans nothing is known to stand, and there sides would go on over all there is.
  [[nodiscard]] bool something_stands() const {
    return std::any_of(votes_.begin(), votes_.end(),
                       [](const PointVotes& v) { return v.total() < kSliding; });
  }

  // The sides of one object after another; whether there are any. The marks are on what moves.
  bool slide() {
    const std::size_t before = dynamic_.size();
    TangentialSurfaces sides(scan_, points_, neighbours_, votes_, marks_);
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      for (const std::int32_t i : sides.of(object(n))) {
        verdict(i) = GrowthVerdict::grown;
        marks_.mark(i);
        dynamic_.push_back(i);
      }
    }
    std::sort(dynamic_.begin(), dynamic_.end());
    return dynamic_.size() != before;
  }

  // Counts what was added beside its neighbours; those for whom it makes enough, in front_.
  void count_beside(const std::vector<std::int32_t>& added, int least,
                    std::vector<std::int8_t>& dynamic_neighbours) {
    front_.clear();
    for (const std::int32_t i : added) {
      neighbours_.for_each<Of::unmarked>(i, kSupportRows, kSupportColumns, marks_, [&](std::int32_t j) {
        const auto n = static_cast<std::size_t>(j);
        if (votes_[n].total() < least) return;
        if (++dynamic_neighbours[n] == kFillNeighbours) front_.push_back(j);
      });
    }
  }

  // What is linked is one object. The marks are on what moves.
  void number_objects() {
    objects_.clear();
    ends_.clear();
    for (const std::int32_t i : dynamic_) result_.object[static_cast<std::size_t>(i)] = 0;
    for (const std::int32_t i : dynamic_) {
      if (result_.object[static_cast<std::size_t>(i)] != 0) continue;
      collect(i);
      objects_.insert(objects_.end(), front_.begin(), front_.end());
      ends_.push_back(objects_.size());
      const auto number = static_cast<std::uint16_t>(std::min<std::size_t>(ends_.size(), kMaxObjectNumber));
      for (const std::int32_t j : front_) result_.object[static_cast<std::size_t>(j)] = number;
    }
    for (const std::int32_t i : objects_) marks_.mark(i);
  }

  [[nodiscard]] std::span<const std::int32_t> object(std::size_t n) const {
    const std::size_t begin = n == 0 ? 0 : ends_[n - 1];
    return std::span(objects_).subspan(begin, ends_[n] - begin);
  }

  void weigh_objects() {
    result_.objects = static_cast<int>(ends_.size());
    result_.evidence.reserve(ends_.size());
    ObjectEvidenceCollector evidence(scan_, points_, votes_, parameters_.min_evidence);
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      result_.evidence.push_back(evidence.of(object(n)));
    }
  }

  const LidarScan& scan_;
  const LinkedNeighbours& neighbours_;
  const LocalPoints& points_;
  const std::vector<PointVotes>& votes_;
  const VotingParameters& parameters_;
  EvidenceGrowthResult result_;
  MarkedReturns marks_;
  std::vector<std::int32_t> candidates_, dynamic_;  // increasing
  std::vector<std::int32_t> front_;
  std::vector<std::int32_t> objects_;  // one after another
  std::vector<std::size_t> ends_;      // of each in objects_
};

}  // namespace

std::vector<BoxVerdict> filter_evidence(const LidarScan& scan, const LocalPoints& points,
                                        const std::vector<PointVotes>& votes,
                                        const VotingParameters& parameters) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  std::vector<BoxVerdict> verdicts(votes.size(), BoxVerdict::not_asked);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, votes.size(), 4096), [&](const auto& chunk) {
    for (std::size_t i = chunk.begin(); i != chunk.end(); ++i) {
      int score = votes[i].total();
      if (score <= 0) continue;
      neighbours.for_each(static_cast<std::int32_t>(i), kSupportRows, kSupportColumns,
                          [&](std::int32_t j) { score += votes[static_cast<std::size_t>(j)].total(); });
      verdicts[i] = score >= parameters.seed_score ? BoxVerdict::kept : BoxVerdict::removed;
    }
  });
  return verdicts;
}

EvidenceGrowthResult grow_evidence(const LidarScan& scan, const LocalPoints& points,
                                   const std::vector<PointVotes>& votes, const std::vector<BoxVerdict>& seeds,
                                   const VotingParameters& parameters) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  return EvidenceGrowth(scan, neighbours, points, votes, parameters).grow(seeds);
}

}  // namespace mapless
