#include "detection/segmentation/evidence_growth.hpp"

#include <algorithm>
#include <bit>
#include <span>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/object_number.hpp"
#include "detection/segmentation/linked_neighbours.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include "detection/segmentation/tangential_surfaces.hpp"

namespace mapless::inline v1 {
namespace {

// Holes are filled where more than a third of the 14 neighbours in the support window are labelled; twice,
// and in kTangentialRounds more where no scan but the recent ones saw a surface. Measured: commit "Fill on
// over what only scans of a moment ago saw": IoU .8560 to .8607 over 32 recordings.
constexpr int kFillRounds = 2, kTangentialRounds = 6;

// Points of a faint cluster. One alone is mostly an edge. Measured: 1 finds .002 IoU more with 16 lasers,
// .001 less with 64, and takes a fifth more time.
constexpr std::size_t kFaintPoints = 2;

// Faint clusters this near to an object's centre are clutter about it: what one may take for the same thing
// in the next scan, at 30 m/s and ten scans a second. Measured: docs/notebook/detection.md, "Clutter".
constexpr float kClutterReach_m = 3;

constexpr std::size_t kReservedCandidates = 8192;  // room for a typical scan, allocated at once
constexpr std::size_t kPointsPerTask = 4096;  // chosen: many tasks a scan, each of several rows of points

class EvidenceGrowth {
  using Of = LinkedNeighbours::Of;

 public:
  EvidenceGrowth(const LidarScan& scan, const LinkedNeighbours& neighbours, const LocalPoints& points,
                 const std::vector<PointEvidence>& votes, const VotingParameters& parameters)
      : scan_(scan),
        neighbours_(neighbours),
        points_(points),
        votes_(votes),
        parameters_(parameters),
        marks_(scan, neighbours.image()) {
    result_.verdict.assign(votes.size(), GrowthVerdict::not_reached);
    result_.object.assign(votes.size(), 0);
  }

  EvidenceGrowthResult grow(const std::vector<FilterVerdict>& seeds) {
    collect_candidates(seeds);
    keep_large_clusters(seeds);
    if (parameters_.grow) spread();
    mark_dynamic();
    if (parameters_.grow) fill();
    number_objects();
    if (parameters_.grow && any_static() && add_tangential_surfaces()) number_objects();
    collect_evidence();
    collect_faint();
    count_clutter();
    return std::move(result_);
  }

 private:
  GrowthVerdict& verdict(std::int32_t i) { return result_.verdict[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool dynamic(std::int32_t i) {
    return verdict(i) == GrowthVerdict::seed || verdict(i) == GrowthVerdict::grown;
  }

  // That an occluder has left is not enough by itself: so it has where it uncovered static points.
  [[nodiscard]] bool may_grow(std::int32_t i) const {
    const PointEvidence& v = votes_[static_cast<std::size_t>(i)];
    return v.total() > 0 || (v.seen_through && v.total() >= kFirmlyStatic);
  }

  // Points that can be more than filled in, a few of the scan.
  void collect_candidates(const std::vector<FilterVerdict>& seeds) {
    candidates_.reserve(kReservedCandidates);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(votes_.size()); ++i) {
      const auto n = static_cast<std::size_t>(i);
      if (votes_[n].total() > 0 || votes_[n].seen_through || seeds[n] == FilterVerdict::kept)
        candidates_.push_back(i);
    }
    for (auto* list : {&front_, &dynamic_, &objects_}) list->reserve(candidates_.size());
  }

  // Moves the marked points connected to `first` from the marks to front_.
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

  void keep_large_clusters(const std::vector<FilterVerdict>& seeds) {
    const auto is_kept = [&](std::int32_t i) {
      return seeds[static_cast<std::size_t>(i)] == FilterVerdict::kept;
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
      } else if (may_grow(i)) {
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

  // Fills holes and rims: points that no scan observed, or few on a surface, belong to the object around
  // them. The marks are on labelled points.
  void fill() {
    std::vector<std::int8_t> dynamic_neighbours(votes_.size(), 0);
    std::vector<std::int32_t> added = dynamic_;
    const std::size_t grown_points = dynamic_.size();
    const MarkedReturns grown = marks_;
    for (int round = 0; round < kFillRounds + kTangentialRounds && !added.empty(); ++round) {
      count_neighbours(added, round < kFillRounds ? kFirmlyStatic : kTangentialVotes, dynamic_neighbours);
      for (const std::int32_t i : front_) {
        verdict(i) = GrowthVerdict::grown;
        marks_.mark(i);
      }
      dynamic_.insert(dynamic_.end(), front_.begin(), front_.end());
      added.swap(front_);
    }
    find_rims(std::span(dynamic_).subspan(grown_points), grown);
    std::sort(dynamic_.begin(), dynamic_.end());
  }

  // The points of `filled`, in the order in which they were, that have too few neighbours in the marked ones
  // and those before them that are no rim, or have them in one row far away.
  void find_rims(std::span<const std::int32_t> filled, MarkedReturns marked) {
    for (const std::int32_t i : filled) {
      const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
      int neighbours = 0;
      unsigned rows = 0;  // one bit each
      neighbours_.for_each<Of::marked>(i, kSupportRows, kSupportColumns, marked, [&](std::int32_t j) {
        ++neighbours;
        rows |= 1U << (scan_.returns[static_cast<std::size_t>(j)].laser - r.laser + kSupportRows);
      });
      const double rows_apart_m = scan_.model->elevation_step(r.laser) * static_cast<double>(r.range_m);
      if (neighbours >= kFillNeighbours && (std::popcount(rows) > 1 || rows_apart_m <= parameters_.link_m)) {
        marked.mark(i);
      } else {
        result_.rims.push_back(i);
      }
    }
  }

  // In the first scans no point of the world is known to be static, and tangential surfaces would extend over
  // all of them.
  [[nodiscard]] bool any_static() const {
    return std::any_of(votes_.begin(), votes_.end(),
                       [](const PointEvidence& v) { return v.total() < kTangentialVotes && !v.own_vehicle; });
  }

  // Adds those of one object after another; returns whether there are any. The marks are on labelled points.
  bool add_tangential_surfaces() {
    TangentialSurfaces surfaces(scan_, neighbours_, votes_, marks_);
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      for (const std::int32_t i : surfaces.of(object(n))) {
        verdict(i) = GrowthVerdict::grown;
        marks_.mark(i);
        dynamic_.push_back(i);
        sliding_.push_back(i);
      }
    }
    std::sort(dynamic_.begin(), dynamic_.end());
    return !sliding_.empty();
  }

  // Counts the added points at their unlabelled neighbours with at least `min_votes`; those that now have
  // enough are in front_.
  void count_neighbours(const std::vector<std::int32_t>& added, int min_votes,
                        std::vector<std::int8_t>& dynamic_neighbours) {
    front_.clear();
    for (const std::int32_t i : added) {
      neighbours_.for_each<Of::unmarked>(i, kSupportRows, kSupportColumns, marks_, [&](std::int32_t j) {
        const auto n = static_cast<std::size_t>(j);
        if (votes_[n].total() < min_votes) return;
        if (++dynamic_neighbours[n] == kFillNeighbours) front_.push_back(j);
      });
    }
  }

  // Numbers the connected sets. The marks are on labelled points.
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
    marks_.mark(objects_);
  }

  [[nodiscard]] std::span<const std::int32_t> object(std::size_t n) const {
    const std::size_t begin = n == 0 ? 0 : ends_[n - 1];
    return std::span(objects_).subspan(begin, ends_[n] - begin);
  }

  void collect_evidence() {
    result_.objects = static_cast<int>(ends_.size());
    result_.evidence.reserve(ends_.size());
    ObjectEvidenceCollector evidence(scan_, points_, votes_, parameters_.min_evidence, sliding_);
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      result_.evidence.push_back(evidence.collect(object(n)));
    }
  }

  // Of what is no object: two linked points or more with votes for them.
  void collect_faint() {
    marks_.clear();
    std::vector<std::int32_t> faint;
    for (const std::int32_t i : candidates_) {
      if (votes_[static_cast<std::size_t>(i)].total() <= 0 || dynamic(i)) continue;
      marks_.mark(i);
      faint.push_back(i);
    }
    std::vector<bool> taken(votes_.size(), false);
    for (const std::int32_t i : faint) {
      if (taken[static_cast<std::size_t>(i)]) continue;
      collect(i);
      for (const std::int32_t j : front_) taken[static_cast<std::size_t>(j)] = true;
      if (front_.size() >= kFaintPoints) result_.faint.push_back(front_);
    }
  }

  void count_clutter() {
    std::vector<Eigen::Vector3f> faint;
    for (const std::vector<std::int32_t>& cluster : result_.faint)
      faint.push_back(centroid(points_, cluster));
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      const Eigen::Vector3f of_object = centroid(points_, object(n));
      result_.evidence[n].clutter =
          static_cast<int>(std::count_if(faint.begin(), faint.end(), [&](const Eigen::Vector3f& one) {
            return (one - of_object).squaredNorm() < kClutterReach_m * kClutterReach_m;
          }));
    }
  }

  const LidarScan& scan_;
  const LinkedNeighbours& neighbours_;
  const LocalPoints& points_;
  const std::vector<PointEvidence>& votes_;
  const VotingParameters& parameters_;
  EvidenceGrowthResult result_;
  MarkedReturns marks_;
  std::vector<std::int32_t> candidates_, dynamic_;  // increasing
  std::vector<std::int32_t> sliding_;               // of dynamic_, by TangentialSurfaces
  std::vector<std::int32_t> front_;
  std::vector<std::int32_t> objects_;  // the points of one object after another
  std::vector<std::size_t> ends_;      // end of each object in objects_
};

}  // namespace

std::vector<FilterVerdict> filter_evidence(const LidarScan& scan, const LocalPoints& points,
                                           const std::vector<PointEvidence>& votes,
                                           const VotingParameters& parameters) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  std::vector<FilterVerdict> verdicts(votes.size(), FilterVerdict::not_evaluated);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, votes.size(), kPointsPerTask), [&](const auto& chunk) {
    for (std::size_t i = chunk.begin(); i != chunk.end(); ++i) {
      int score = votes[i].total();
      if (score <= 0) continue;
      neighbours.for_each(static_cast<std::int32_t>(i), kSupportRows, kSupportColumns,
                          [&](std::int32_t j) { score += votes[static_cast<std::size_t>(j)].total(); });
      verdicts[i] = score >= parameters.seed_score ? FilterVerdict::kept : FilterVerdict::removed;
    }
  });
  return verdicts;
}

EvidenceGrowthResult grow_evidence(const LidarScan& scan, const LocalPoints& points,
                                   const std::vector<PointEvidence>& votes,
                                   const std::vector<FilterVerdict>& seeds,
                                   const VotingParameters& parameters) {
  const LinkedNeighbours neighbours(scan, points, parameters);
  return EvidenceGrowth(scan, neighbours, points, votes, parameters).grow(seeds);
}

}  // namespace mapless
