#include "reports/evaluation_json.hpp"

#include <cmath>

#include "reports/json.hpp"

namespace mapless::app {
namespace {

Json rate_json(const std::optional<double>& rate) { return rate ? Json(*rate) : Json(nullptr); }

Json to_json(const FalseObjects& f) {
  return {{"per_scan", rate_json(f.per_scan())},
          {"false", f.false_ones},
          {"objects", f.objects},
          {"scans", f.scans},
          {"unnumbered_points", f.unnumbered_points}};
}

Json to_json(const std::optional<Found>& found) {
  return found ? mapless::app::to_json(*found) : Json(nullptr);
}

Json merged(Json first, const Json& second) {
  first.update(second);
  return first;
}

template <class What>
Json to_json(const Band<What>& band) {
  const Json up_to = std::isfinite(band.up_to) ? Json(band.up_to) : Json(nullptr);
  return merged({{"above", band.above}, {"up_to", up_to}}, mapless::app::to_json(band.counts));
}

Json to_json(const RangeLimitReport& within) {
  return merged({{"limit_m", within.limit_m}}, mapless::app::to_json(within.points));
}

Json to_json(const ClassReport& c) {
  return {{"class", c.object_class},
          {"points", mapless::app::to_json(c.points)},
          {"objects", mapless::app::to_json(c.objects)},
          {"evident_movers", to_json(c.evident_movers)}};
}

Json to_json(const KindReport& k) {
  return merged({{"class", k.object_class}, {"kind", k.kind}}, mapless::app::to_json(k.points));
}

Json to_json(const Delays& d) {
  return {{"events", d.events},
          {"never", d.never},
          {"median_scans", rate_json(d.median_scans)},
          {"p90_scans", rate_json(d.p90_scans)}};
}

// Null where there is none.
template <class What>
Json list_json(const std::vector<What>& list) {
  if (list.empty()) return nullptr;
  Json out = Json::array();
  for (const What& item : list) out.push_back(to_json(item));
  return out;
}

}  // namespace

Json to_json(const Counts& c) {
  return {{"tp", c.tp},
          {"fp", c.fp},
          {"fn", c.fn},
          {"tn", c.tn},
          {"precision", rate_json(c.precision())},
          {"recall", rate_json(c.recall())},
          {"f1", rate_json(c.f1())},
          {"iou", rate_json(c.iou())}};
}

Json to_json(const PrecisionRecall& r) {
  return merged(merged({{"scans", r.scans()}}, to_json(r.total())),
                {{"average_precision", rate_json(r.average_precision())},
                 {"n_p", r.precision_scans()},
                 {"average_recall", rate_json(r.average_recall())},
                 {"n_r", r.recall_scans()}});
}

Json to_json(const Found& f) { return {{"share", rate_json(f.share())}, {"found", f.found}, {"of", f.of}}; }

Json to_json(const EvaluationReport& r) {
  return {{"points", to_json(r.points)},
          {"by_range", list_json(r.by_range)},
          {"within_range", list_json(r.within_range)},
          {"by_class", list_json(r.by_class)},
          {"by_kind", list_json(r.by_kind)},
          {"by_speed", list_json(r.by_speed)},
          {"by_visible_points", list_json(r.by_visible_points)},
          {"objects", to_json(r.objects)},
          {"evident_movers", to_json(r.evident_movers)},
          {"false_objects", to_json(r.false_objects)}};
}

Json to_json(const VelocityReport& r) {
  return {{"evaluated", r.evaluated},
          {"first_seen", r.first_seen},
          {"mixed", r.mixed},
          {"rms_mps", rate_json(r.rms_mps)},
          {"median_mps", rate_json(r.median_mps)},
          {"small_error_share", rate_json(r.small_error_share)},
          {"normalised_rms", rate_json(r.normalised_rms)},
          {"confident", r.confident},
          {"confident_rms_mps", rate_json(r.confident_rms_mps)},
          {"movers", r.movers},
          {"id_changes", r.id_changes}};
}

Json to_json(const SightReport& r) {
  return {{"through_gap", to_json(r.through_gap)}, {"before_sky", to_json(r.before_sky)}};
}

Json to_json(const DelayReport& r) { return {{"start", to_json(r.start)}, {"stop", to_json(r.stop)}}; }

}  // namespace mapless::app
