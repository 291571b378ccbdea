#include "explain/point_report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "explain/reasons.hpp"
#include <mapless/io/labels.hpp>

namespace mapless::app {
namespace {

// Scans of an object's history that the text shows, before and up to the scan of the point.
constexpr std::size_t kHistoryRows = 10;

std::string number(double value, int decimals = 2) { return fmt::format("{:.{}f}", value, decimals); }

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

// JSON has no NaN.
Json metres(float value) {
  return std::isnan(value) ? Json(nullptr) : Json(rounded(static_cast<double>(value)));
}

Figures with(Figures figures, const Figures& more) {
  for (const auto& [name, value] : more) figures[name] = value;
  return figures;
}

std::string metres_text(double value) { return text_of_steps(steps_of(std::abs(value))); }

Figures figures_of(const Observation& o) {
  const auto short_m = static_cast<double>(o.short_by_m);
  const bool known = !std::isnan(short_m);
  const std::string short_text = known ? metres_text(short_m) : "";
  return {{"beyond", short_text},
          {"short", short_text},
          {"aside", metres_text(static_cast<double>(o.aside_m))},
          {"distance", metres_text(static_cast<double>(o.occluder_distance_m))},
          {"off", !known        ? "a neighbouring ray ends on it"
                  : short_m > 0 ? "the nearest ray ends " + short_text + " m before the point"
                                : "the nearest ray ends " + short_text + " m behind it"}};
}

Figures figures_of(const PointDecision& p) {
  return {{"votes", std::to_string(p.votes())},
          {"support", std::to_string(p.support)},
          {"supporters", std::to_string(p.supporters)},
          {"near", std::to_string(p.near_labelled)}};
}

Figures figures_of(const ObjectDecision& d) {
  return {{"evidence", number(d.evidence, 0)},
          {"required", number(d.required, 0)},
          {"clutter", number(d.clutter, 0)},
          {"displacement", number(d.displacement_m)},
          {"speed", number(d.object.velocity_0.norm())},
          {"std", number(d.object.velocity_std_0().maxCoeff())}};
}

Json observation_json(const Observation& o, const PointDecision& p, std::size_t scan, int gap,
                      const Figures& limits, const DecisionLimits& exact) {
  const ObservationKind kind = kind_of(o, exact);
  const bool slow = p.may_be_slow && std::abs(gap) == 1 && kind == ObservationKind::surface && !o.agrees;
  const ReasonText& words =
      kObservationTexts.at(static_cast<std::size_t>(slow ? ObservationKind::slow_surface : kind));
  std::string text = filled_in(words.text, with(limits, figures_of(o)));
  if (o.agrees) text += "; the ranges of the scans change steadily, as of a surface moving along the rays";
  return {{"scan", static_cast<std::size_t>(static_cast<long>(scan) - gap)},
          {"gap", gap},
          {"kind", words.name},
          {"votes", slow ? 0 : o.votes},
          {"short_by_m", o.laser < 0 ? Json(nullptr) : metres(o.short_by_m)},
          {"aside_m", o.laser < 0 ? Json(nullptr) : metres(o.aside_m)},
          {"text", text}};
}

// By time, the latest last.
Json observations_json(const ExplainedPoint& point, const Figures& limits) {
  const ScanExplanation& e = *point.labelled->detection.explanation;
  const std::size_t references = e.gaps.size();
  std::vector<std::size_t> order(references);
  for (std::size_t k = 0; k < references; ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return e.gaps[a] > e.gaps[b]; });
  Json out = Json::array();
  const auto source = static_cast<std::size_t>(e.source[point.at]);
  for (const std::size_t k : order) {
    out.push_back(observation_json(e.observations[source * references + k], e.points[point.at], point.scan,
                                   e.gaps[k], limits, e.limits));
  }
  return out;
}

Json decision_json(std::size_t scan, const ObjectDecision& d, const Figures& limits) {
  return {{"scan", scan},
          {"moves", d.moves},
          {"reason", kTrackTexts.at(static_cast<std::size_t>(d.reason)).name},
          {"text", decision_text(d, limits)},
          {"speed_mps", rounded(d.object.velocity_0.norm())},
          {"speed_std_mps", rounded(d.object.velocity_std_0().maxCoeff())},
          {"points", d.object.points},
          {"age_scans", d.object.age},
          {"votes", d.votes},
          {"evidence", rounded(d.evidence)},
          {"required", rounded(d.required)},
          {"clutter", rounded(d.clutter)},
          {"displacement_m", rounded(d.displacement_m)}};
}

std::string verdict_of(const Json& point) {
  if (point["label"] == "dynamic") return fmt::format("DYNAMIC, object {}", point["object"]["id"].dump());
  return point["label"] == "static" ? "STATIC" : "WITHOUT LABEL";
}

std::string table_of_rays(const Json& point) {
  std::string out = "\nWhat the rays of other scans say of its place:\n  scan    gap  votes\n";
  for (const Json& o : point["observations"]) {
    out += fmt::format("  {:>5}  {:>+4}  {:>+5}  {}\n", o["scan"].get<std::size_t>(), -o["gap"].get<int>(),
                       o["votes"].get<int>(), o["text"].get<std::string>());
  }
  const Json& votes = point["votes"];
  return out + fmt::format("  sum          {:>+5}  {:+} of earlier, {:+} of later scans\n",
                           votes["total"].get<int>(), votes["past"].get<int>(), votes["future"].get<int>());
}

std::string table_of_object(const Json& object) {
  std::string out = fmt::format(
      "\nIts object, track {}, by scan:\n  scan   points  speed m/s      evidence        decision\n",
      object["track"].dump());
  const Json& history = object["history"];
  const std::size_t skipped = history.size() - std::min(history.size(), kHistoryRows);
  const auto begins = [](const Json& h) { return h["reason"] == kTrackTexts.at(1).name; };
  for (std::size_t n = 0; n < history.size(); ++n) {
    const Json& h = history[n];
    if (n < skipped && !begins(h)) continue;
    out += fmt::format("  {:>5}  {:>5}  {:>6.2f} +- {:<5.2f} {:>5.0f}  {}: {}\n",
                       h["scan"].get<std::size_t>(), h["points"].get<int>(), h["speed_mps"].get<double>(),
                       h["speed_std_mps"].get<double>(), h["evidence"].get<double>(),
                       h["moves"].get<bool>() ? "dynamic" : "static", h["reason"].get<std::string>());
  }
  return out;
}

}  // namespace

Figures limit_figures(const VotingParameters& p, const DecisionLimits& limits) {
  return {{"through_within", number(limits.through_within_m)},
          {"fill_neighbours", std::to_string(limits.fill_neighbours)},
          {"firmly_static", std::to_string(limits.firmly_static_votes)},
          {"seed_score", std::to_string(p.seed_score)},
          {"min_seeds", std::to_string(p.min_seeds)},
          {"min_displacement", number(p.min_displacement_m)},
          {"min_speed", number(p.min_speed_mps)}};
}

std::string filled_in(std::string_view text, const Figures& figures) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t open = text.find('{', at), close = text.find('}', at);
    out += text.substr(at, open - at);
    if (open == std::string_view::npos) break;
    const auto found = figures.find(std::string(text.substr(open + 1, close - open - 1)));
    out += found == figures.end() ? "?" : found->second;
    at = close + 1;
  }
  return out;
}

std::string decision_text(const ObjectDecision& decision, Figures figures) {
  return filled_in(kTrackTexts.at(static_cast<std::size_t>(decision.reason)).text,
                   with(std::move(figures), figures_of(decision)));
}

Json point_json(const ExplainedPoint& point, const VotingParameters& parameters) {
  const Detection& detection = point.labelled->detection;
  const ScanExplanation& e = *detection.explanation;
  const LidarReturn& r = detection.scan->returns[point.at];
  const PointDecision& p = e.points[point.at];
  const Figures limits = limit_figures(parameters, e.limits);
  const ReasonText& step = kPointTexts.at(static_cast<std::size_t>(step_of(p, e.limits)));
  const auto spacing = detection.scan->model->elevation_step(r.laser);
  const auto source = static_cast<std::size_t>(e.source[point.at]);
  Json out = {{"scan", point.scan},
              {"point", r.input_index},
              {"label", detection.dynamic(point.at) ? "dynamic" : "static"},
              {"laser", r.laser},
              {"column", r.column},
              {"range_m", metres(r.range_m)},
              {"tolerance_m", rounded(e.limits.tolerance_m + parameters.tolerance_spacings * spacing *
                                                                 static_cast<double>(r.range_m))},
              {"evidence_of", detection.scan->returns[source].input_index},
              {"votes", {{"past", p.past}, {"future", p.future}, {"total", p.votes()}}},
              {"observations", p.own_vehicle ? Json::array() : observations_json(point, limits)},
              {"step", step.name},
              {"step_text", filled_in(step.text, with(limits, figures_of(p)))}};
  if (p.proposed == 0) return out;
  const ObjectDecision& decision = point.history.at(point.scan);
  Json history = Json::array();
  for (const auto& [scan, d] : point.history) history.push_back(decision_json(scan, d, limits));
  out["object"] = {{"id", decision.object.id},
                   {"number", decision.object.id == 0 ? 0 : label_number(decision.object.id)},
                   {"track", decision.track},
                   {"reason", kTrackTexts.at(static_cast<std::size_t>(decision.reason)).name},
                   {"text", decision_text(decision, limits)},
                   {"history", std::move(history)}};
  return out;
}

std::string point_text(const Json& point) {
  std::string out =
      fmt::format("Point {} of scan {} is {}.\nLaser {}, column {}, range {:.2f} m\n", point["point"].dump(),
                  point["scan"].dump(), verdict_of(point), point["laser"].dump(), point["column"].dump(),
                  point["range_m"].get<double>());
  out += fmt::format("\nDecided by: {}. {}\n",
                     point.contains("object") ? "its object, " + point["object"]["reason"].get<std::string>()
                                              : point["step"].get<std::string>(),
                     point.contains("object") ? point["object"]["text"].get<std::string>()
                                              : point["step_text"].get<std::string>());
  if (point.contains("object"))
    out += fmt::format("It is part of it by {}. {}\n", point["step"].get<std::string>(),
                       point["step_text"].get<std::string>());
  if (point["evidence_of"] != point["point"]) {
    out += fmt::format("No scan was queried about it: it has the evidence of point {} of the same surface.\n",
                       point["evidence_of"].dump());
  }
  if (!point["observations"].empty()) out += table_of_rays(point);
  out += fmt::format(
      "A ray that ends within {:.2f} m of the point, or less where its surface is square to the rays, saw "
      "its surface. So did one that ends behind it, in the plane of the surface.\n",
      point["tolerance_m"].get<double>());
  if (point.contains("object")) out += table_of_object(point["object"]);
  return out;
}

}  // namespace mapless::app
