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

// A point with no vote for it is settled as static at this sum of votes against it: what the first three
// scans of query_order, 32, 12 and 4 back, give together (4 + 3 + 2). Measured: docs/notebook/speed.md.
constexpr int kSettledVotes = 9;
// Once six scans were queried, fewer do: some could not observe the point, all others saw a surface there.
// Measured: docs/notebook/speed.md.
constexpr std::size_t kManyQueried = 6;
constexpr int kSettledVotesOfMany = 6;

// Two standard deviations of the difference between two ranges, as a share of the tolerance, which is
// kToleratedDeviations of one range.
constexpr double kSurfaceNoise = 2 * std::numbers::sqrt2 / kToleratedDeviations;

// Scans older than this are queried last, and thus only where the others do not settle a point: a point that
// was static for 3 s is static. Measured: docs/notebook/detection.md, "the last 32".
constexpr int kOldGap = 32;  // [scans]

// Every third from the oldest on: the first three queried then cover seconds ago and a moment ago.
constexpr std::size_t kQueryStride = 3;

// A departure contradicts the next scan where the object would have gone on by more than this many
// tolerances, or this many times the offset of the surface seen instead. Chosen: below 2 the range noise of
// both scans alone contradicts true departures.
constexpr float kClearlyMoved = 2;

// Offsets along the rays beyond this are of another surface.
constexpr float kMaxOffset_m = 2;
// Standard deviation of an offset, as a share of the tolerance, which is four of one range: noise of both
// ranges, and surfaces that are not quite planes. Any from 0.3 to 0.5 gives the same.
constexpr float kOffsetStd = 0.5F;
// How far away in the row the neighbours lie that give the slope of a point that moves along the rays: the
// range of nearer ones differs by noise.
constexpr int kRangeRateColumns = 3;

// In a longer turn a thing at walking pace moves by more than the tolerance, so what the scans beside saw
// tells. Measured: docs/notebook/detection.md, "Slow things".
constexpr double kSlowTurn_s = 0.12;

// The larger one. Rays pass far beside a point between two lasers only: where neither of the lasers beside
// has a return, as on the crest of a hill, an offset may be all slope. To the side, unknown counts as 0.
float steepest(SurfaceSlopes slopes) {
  return std::max(slopes.up, slopes.left < SurfaceSlopes::kUnknown ? slopes.left : 0);
}

std::vector<ReferenceScan> query_order(std::vector<ReferenceScan> references) {
  std::stable_sort(references.begin(), references.end(), [](const ReferenceScan& a, const ReferenceScan& b) {
    return std::abs(a.gap) > std::abs(b.gap);
  });
  const auto recent_begin = std::stable_partition(references.begin(), references.end(),
                                                  [](const ReferenceScan& r) { return r.gap > kOldGap; });
  const std::span recent(recent_begin, references.end());
  std::vector<ReferenceScan> ordered;
  ordered.reserve(references.size());
  for (std::size_t first = 0; first < kQueryStride; ++first) {
    for (std::size_t k = first; k < recent.size(); k += kQueryStride) ordered.push_back(recent[k]);
  }
  ordered.insert(ordered.end(), references.begin(), recent_begin);
  return ordered;
}

// The largest gap that counts as recent.
int recent_gap(const std::vector<ReferenceScan>& references) {
  int nearest = std::numeric_limits<int>::max();
  for (const ReferenceScan& r : references) nearest = std::min(nearest, std::abs(r.gap));
  return std::max(nearest, kRecentGap);
}

// The gap of the nearest later scan, 0 where there is none.
int next_gap(const std::vector<ReferenceScan>& references) {
  int next = 0;
  for (const ReferenceScan& r : references) {
    if (r.gap < 0 && (next == 0 || r.gap > next)) next = r.gap;
  }
  return next;
}

}  // namespace

EvidenceCollector::EvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                                     const std::vector<ReferenceScan>& references, const RayImage& own,
                                     const VotingParameters& parameters, ScanExplanation* explanation,
                                     const std::vector<ReferenceScan>& others)
    : scan_(scan),
      points_(points.points),
      slopes_(scan, points_),
      max_occluder_distance_m_(static_cast<float>(parameters.max_occluder_distance_m)),
      surface_noise_m_(static_cast<float>(kSurfaceNoise * parameters.tolerance_m)),
      own_(own, points.origin_0, parameters),
      planes_(scan, points_, own_.tolerance_m(0, 0)),
      explanation_(explanation) {
  const int recent = recent_gap(references), next = next_gap(references);
  const bool slow_turn = (scan.end() - scan.start).seconds() > kSlowTurn_s;
  references_.reserve(references.size());
  for (const ReferenceScan& r : query_order(references)) {
    references_.push_back({FreespaceProbe(*r.image, points.origin_0, parameters),
                           surface_votes(std::abs(r.gap)), r.gap < 0, r.gap == next,
                           std::abs(r.gap) <= recent, !slow_turn && std::abs(r.gap) == 1, r.gap,
                           references_.size()});
    if (explanation_) explanation_->gaps.push_back(r.gap);
  }
  for (const ReferenceScan& r : others) {
    others_.push_back({FreespaceProbe(*r.image, points.origin_0, parameters), surface_votes(r.gap), false,
                       false, r.gap <= recent, false, r.gap, others_.size()});
  }
  if (explanation_) explanation_->observations.assign(points_.size() * references_.size(), {});
}

// One scan after another for all points, so that its poses and ranges stay in the cache.
void EvidenceCollector::query(const std::vector<std::size_t>& returns, Workspace& work,
                              std::vector<PointEvidence>& evidence) const {
  start(returns, work);
  for (std::size_t k = 0; k < references_.size() && !work.open.empty(); ++k) {
    query_reference(references_[k], work);
    settle(k + 1, work);
  }
  query_others(work);
  add_departed(work);
  for (const std::size_t k : work.open) add_range_rate(k, work);
  for (const PointQuery& query : work.queries) evidence[query.i] = query.evidence;
}

void EvidenceCollector::start(const std::vector<std::size_t>& returns, Workspace& work) const {
  work.queries.clear();
  work.open.clear();
  work.departed.clear();
  work.points.clear();
  work.offsets.resize(returns.size() * references_.size());
  for (const std::size_t i : returns) {
    work.open.push_back(work.queries.size());
    work.queries.push_back({static_cast<std::uint32_t>(i), {}});
    work.points.add(points_[i], column(i), slopes_.of(i, 1));
  }
}

void EvidenceCollector::query_reference(const Reference& reference, Workspace& work) const {
  work.occluders.clear();
  work.points.observe(reference.probe, [&](std::size_t k, FreespaceProbe::Answer answer) {
    PointQuery& query = work.queries[work.open[k]];
    const int before = query.evidence.total();
    if (hit_plane(reference, answer, query.i)) answer.verdict = FreespaceVerdict::border;
    add_answer(reference, answer, query, work);
    if (Observation* const o = recorded(reference, query.i)) {
      const bool fired = answer.laser >= 0;
      *o = {answer.verdict,
            OccluderVerdict::not_examined,
            fired && reference.probe.ended(answer),
            fired && reference.probe.dynamic(answer),
            false,
            static_cast<std::int16_t>(query.evidence.total() - before),
            answer.laser,
            answer.short_by_m,
            answer.aside_m,
            0};
    }
  });
  find_departed(reference, work);
}

// Whether the ray went on past return i, but ended in the plane of its surface.
bool EvidenceCollector::hit_plane(const Reference& reference, const FreespaceProbe::Answer& answer,
                                  std::size_t i) const {
  return answer.verdict == FreespaceVerdict::inside && -answer.short_by_m <= SurfacePlanes::kReach_m &&
         reference.probe.ended(answer) &&
         planes_.contains(i, reference.probe.endpoint(answer.laser, answer.column));
}

// The reference scans after the first `queried` count as if they saw a surface at a settled point.
void EvidenceCollector::settle(std::size_t queried, Workspace& work) const {
  int possible = 0;
  for (std::size_t k = 0; k < queried; ++k) possible += references_[k].surface_votes;
  const int enough = queried < kManyQueried ? kSettledVotes : kSettledVotesOfMany;
  if (possible < enough) return;
  std::size_t still_open = 0;
  for (std::size_t n = 0; n < work.open.size(); ++n) {
    PointQuery& query = work.queries[work.open[n]];
    PointEvidence& evidence = query.evidence;
    if (is_static(evidence) && evidence.total() <= -enough && !query.occluder_left) {
      for (std::size_t k = queried; k < references_.size(); ++k) {
        const int votes = -references_[k].surface_votes;
        add_votes(references_[k], votes, evidence);
        if (Observation* const o = recorded(references_[k], query.i))
          o->votes = static_cast<std::int16_t>(votes);
      }
      continue;
    }
    if (still_open != n) {
      work.open[still_open] = work.open[n];
      work.points.move(n, still_open);
    }
    ++still_open;
  }
  work.open.resize(still_open);
  work.points.shrink(still_open);
}

void EvidenceCollector::add_votes(const Reference& reference, int votes, PointEvidence& evidence) {
  std::int16_t& sum = reference.later ? evidence.future : evidence.past;
  sum = static_cast<std::int16_t>(sum + votes);
}

void EvidenceCollector::add_answer(const Reference& reference, const FreespaceProbe::Answer& answer,
                                   PointQuery& query, Workspace& work) const {
  PointEvidence& evidence = query.evidence;
  const bool surface = answer.verdict == FreespaceVerdict::border && !reference.probe.dynamic(answer);
  add_offset(reference, answer, surface ? reference.surface_votes : 0, query, work);
  if (answer.verdict == FreespaceVerdict::inside) {
    const bool beside = answer.aside_m > kSeenThroughWithin_m || answer.surface_beside;
    add_votes(reference, beside && reference.probe.ended(answer) ? kPassedBesideVotes : kSeenThroughVotes,
              evidence);
    ++(beside ? evidence.rays_beside : evidence.rays_through);
    evidence.beside_m += beside ? answer.aside_m : 0;
    evidence.seen_through = true;
    evidence.recently_free = evidence.recently_free || reference.recent;
  } else if (answer.verdict == FreespaceVerdict::border) {
    const bool dynamic = reference.probe.dynamic(answer);
    if (!dynamic) add_votes(reference, -reference.surface_votes, evidence);
    evidence.surface_last = evidence.surface_last || (!dynamic && reference.beside && !reference.later);
    evidence.surface_next = evidence.surface_next || (!dynamic && reference.beside && reference.later);
    if (dynamic && reference.recent) add_votes(reference, kSeenDynamicVotes, evidence);
    evidence.seen_dynamic = evidence.seen_dynamic || (dynamic && reference.recent);
    evidence.surface_seen = true;
    evidence.stood_before = evidence.stood_before || (!dynamic && !reference.recent);
    query.seen_next = query.seen_next || reference.next;
    if (reference.next) query.next_offset_m = std::abs(answer.short_by_m);
  } else if (answer.verdict == FreespaceVerdict::outside && answer.short_by_m <= max_occluder_distance_m_ &&
             reference.probe.ended(answer) && reference.later == reference.next) {
    reference.probe.prepare_endpoint(answer.column);
    work.occluders.push_back({&query, answer.laser, answer.column});
  }
}

// Another sensor sees a surface at another angle, between other rings and past other edges: a ray of it that
// passes farther aside than kSeenThroughWithin_m tells nothing of the point. That it saw a surface there, or
// something before it, is no evidence against the point, but takes back what its other scans saw through.
void EvidenceCollector::query_others(Workspace& work) const {
  if (others_.empty() || work.open.empty()) return;
  work.others.assign(work.open.size(), {});
  for (const Reference& reference : others_) {
    work.points.observe(reference.probe, [&](std::size_t k, const FreespaceProbe::Answer& answer) {
      Workspace::OtherSensors& other = work.others[k];
      if (answer.verdict == FreespaceVerdict::inside && answer.aside_m <= kSeenThroughWithin_m) {
        other.seen_through += kSeenThroughVotes;
        other.recently = other.recently || reference.recent;
      } else if (answer.verdict == FreespaceVerdict::border && !reference.probe.dynamic(answer)) {
        other.surface += reference.surface_votes;
      }
    });
  }
  for (std::size_t k = 0; k < work.open.size(); ++k) {
    const Workspace::OtherSensors& other = work.others[k];
    if (other.seen_through <= other.surface) continue;
    PointEvidence& evidence = work.queries[work.open[k]].evidence;
    evidence.past = static_cast<std::int16_t>(evidence.past + other.seen_through - other.surface);
    evidence.seen_through = true;
    evidence.recently_free = evidence.recently_free || other.recently;
  }
}

void EvidenceCollector::add_offset(const Reference& reference, const FreespaceProbe::Answer& answer,
                                   int surface_votes, PointQuery& query, Workspace& work) const {
  // NaN where the range is not known.
  if (answer.laser < 0 || !(std::abs(answer.short_by_m) <= kMaxOffset_m) || !reference.probe.ended(answer))
    return;
  const auto number = static_cast<std::size_t>(&query - work.queries.data());
  const std::size_t at = number * references_.size() + query.offsets++;
  work.offsets[at] = {reference.gap, answer.short_by_m, answer.aside_m, surface_votes};
}

// Scans that agree with a motion along the rays vote for the point in place of against it.
void EvidenceCollector::add_range_rate(std::size_t number, Workspace& work) const {
  PointQuery& query = work.queries[number];
  const std::span offsets = std::span(work.offsets).subspan(number * references_.size(), query.offsets);
  if (!moves_along_rays(offsets, kOffsetStd * own_.tolerance_m(0, 0),
                        steepest(slopes_.of(query.i, kRangeRateColumns))))
    return;
  PointEvidence& evidence = query.evidence;
  for (const RangeOffset& offset : offsets) {
    if (!offset.agrees) continue;
    std::int16_t& sum = offset.gap < 0 ? evidence.future : evidence.past;
    sum = static_cast<std::int16_t>(sum + offset.surface_votes + kRangeRateVotes);
    if (offset.gap == 1) evidence.surface_last = false;
    if (offset.gap == -1) evidence.surface_next = false;
    for (const Reference& reference : references_) {
      if (reference.gap != offset.gap) continue;
      if (Observation* const o = recorded(reference, query.i)) {
        o->agrees = true;
        o->votes = static_cast<std::int16_t>(o->votes + offset.surface_votes + kRangeRateVotes);
      }
    }
  }
  evidence.occluder_left = true;
  evidence.recently_free = true;
}

// Of the occluders near enough to be of the same object, those whose place the query scan observes free.
void EvidenceCollector::find_departed(const Reference& reference, Workspace& work) const {
  work.places.clear();
  std::erase_if(work.occluders, [&](Workspace::Occluder& occluder) {
    const Eigen::Vector3f place = reference.probe.endpoint(occluder.laser, occluder.column);
    const std::size_t i = occluder.query->i;
    occluder.distance2_m2 = (place - points_[i]).squaredNorm();
    if (occluder.distance2_m2 > max_occluder_distance_m_ * max_occluder_distance_m_) return true;
    work.places.add(place, column(i));
    return false;
  });
  work.places.observe(own_, [&](std::size_t k, const FreespaceProbe::Answer& answer) {
    const Workspace::Occluder& occluder = work.occluders[k];
    if (Observation* const o = recorded(reference, occluder.query->i)) {
      o->occluder = OccluderVerdict::still_there;
      o->occluder_distance_m = std::sqrt(occluder.distance2_m2);
    }
    if (answer.verdict != FreespaceVerdict::inside) return;
    occluder.query->occluder_left = true;
    work.departed.push_back({occluder.query, &reference, std::sqrt(occluder.distance2_m2)});
  });
}

void EvidenceCollector::add_departed(Workspace& work) const {
  for (const Workspace::DepartedOccluder& occluder : work.departed) {
    if (consistent_with_departure(occluder)) continue;
    int& gap = occluder.query->uncovered_gap;
    gap = std::min(gap, occluder.reference->gap);
  }
  for (const Workspace::DepartedOccluder& occluder : work.departed) {
    const bool consistent = occluder.reference->gap < occluder.query->uncovered_gap;
    if (Observation* const o = recorded(*occluder.reference, occluder.query->i)) {
      o->occluder = consistent ? OccluderVerdict::left : OccluderVerdict::contradicted;
      o->votes = static_cast<std::int16_t>(o->votes + (consistent ? kOccluderLeftVotes : 0));
    }
    if (!consistent) continue;
    PointEvidence& evidence = occluder.query->evidence;
    add_votes(*occluder.reference, kOccluderLeftVotes, evidence);
    evidence.occluder_left = true;
    evidence.recently_free = evidence.recently_free || occluder.reference->recent;
  }
}

bool EvidenceCollector::consistent_with_departure(const Workspace::DepartedOccluder& occluder) const {
  if (occluder.reference->later || !occluder.query->seen_next) return true;
  const LidarReturn& r = scan_.returns[occluder.query->i];
  const float displacement_m = occluder.distance_m / static_cast<float>(occluder.reference->gap);
  // std::min is the first of the two where next_offset_m is NaN: that surface was beside the firing.
  const float explained_m = std::min(kClearlyMoved * own_.tolerance_m(r.laser, r.range_m),
                                     surface_noise_m_ + kClearlyMoved * occluder.query->next_offset_m);
  return displacement_m <= explained_m;
}

}  // namespace mapless
