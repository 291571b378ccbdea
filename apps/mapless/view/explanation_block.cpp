#include "view/explanation_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "explain/point_report.hpp"
#include "explain/reasons.hpp"
#include "view/planes.hpp"
#include "view/scan_block.hpp"

namespace mapless::app {
namespace {

constexpr std::uint8_t kAgrees = 16;
constexpr std::size_t kCodes = 32;    // of kinds, with and without agreement
constexpr unsigned kMayBeSlow = 128;  // in the byte of a step
constexpr std::uint16_t kNotKnown = 65535;

std::uint8_t code_of(const Observation& o, const DecisionLimits& limits) {
  const auto kind = static_cast<std::uint8_t>(kind_of(o, limits));
  return static_cast<std::uint8_t>(kind | (o.agrees ? kAgrees : 0U));
}

std::uint16_t distance_code(double metres) {
  if (std::isnan(metres)) return kNotKnown;
  return static_cast<std::uint16_t>(std::min(2 * steps_of(std::abs(metres)) + (metres < 0 ? 1 : 0), 65534));
}

// The votes of one reference scan are the same for all observations of one kind.
Json votes_json(const ScanExplanation& e, std::size_t reference) {
  std::array<int, kCodes> votes = {};
  for (std::size_t i = 0; i < e.points.size(); ++i) {
    if (e.source[i] != static_cast<std::int32_t>(i)) continue;
    const Observation& o = e.observations[i * e.gaps.size() + reference];
    votes.at(code_of(o, e.limits)) = o.votes;
  }
  return votes;
}

Json decisions_json(const ScanExplanation& e) {
  Json objects = Json::array();
  const auto rounded = [](double v) { return std::round(v * 100) / 100; };
  for (const ObjectDecision& d : e.objects) {
    objects.push_back({{"id", d.object.id},
                       {"moves", d.moves},
                       {"reason", static_cast<int>(d.reason)},
                       {"evidence", std::round(d.evidence)},
                       {"required", std::round(d.required)},
                       {"clutter", std::round(d.clutter)},
                       {"displacement", rounded(d.displacement_m)},
                       {"speed", rounded(d.object.velocity_0.norm())},
                       {"std", rounded(d.object.velocity_std_0().maxCoeff())},
                       {"points", d.object.points},
                       {"age", d.object.age}});
  }
  Json votes = Json::array();
  for (std::size_t k = 0; k < e.gaps.size(); ++k) votes.push_back(votes_json(e, k));
  return {{"gaps", e.gaps}, {"votes", std::move(votes)}, {"objects", std::move(objects)}};
}

void append_points(std::string& out, const ScanExplanation& e) {
  std::vector<std::uint32_t> sources;
  std::vector<std::uint16_t> proposed, support;
  std::string steps, supporters, near;
  for (std::size_t i = 0; i < e.points.size(); ++i) {
    const PointDecision& p = e.points[i];
    const bool has_support = p.votes() > 0;  // else no text names it
    sources.push_back(static_cast<std::uint32_t>(e.source[i]));
    steps.push_back(
        static_cast<char>(static_cast<unsigned>(step_of(p, e.limits)) | (p.may_be_slow ? kMayBeSlow : 0U)));
    proposed.push_back(p.proposed);
    support.push_back(static_cast<std::uint16_t>(has_support ? p.support : 0));
    supporters.push_back(static_cast<char>(has_support ? p.supporters : 0));
    near.push_back(static_cast<char>(p.near_labelled));
  }
  append_planes(out, sources);
  out += steps;
  append_planes(out, proposed);
  append_planes(out, support);
  out += supporters + near;
}

void append_observations(std::string& out, const ScanExplanation& e, std::size_t reference) {
  using enum ObservationKind;
  std::string low, high, asides;
  for (std::size_t i = 0; i < e.points.size(); ++i) {
    if (e.source[i] != static_cast<std::int32_t>(i)) continue;
    const Observation& o = e.observations[i * e.gaps.size() + reference];
    const ObservationKind kind = kind_of(o, e.limits);
    out.push_back(static_cast<char>(code_of(o, e.limits)));
    if (kind < edge) continue;
    const bool departed = kind == hider_left || kind == hider_contradicted;
    const std::uint16_t code =
        distance_code(static_cast<double>(departed ? o.occluder_distance_m : o.short_by_m));
    low.push_back(static_cast<char>(code & 0xFFU));
    high.push_back(static_cast<char>(code >> 8U));
    if (kind >= through && kind <= nothing_met)
      asides.push_back(static_cast<char>(std::min(steps_of(static_cast<double>(o.aside_m)), 255)));
  }
  out += low + high + asides;
}

template <std::size_t size>
Json texts_json(const std::array<ReasonText, size>& texts) {
  Json out = Json::array();
  for (const ReasonText& one : texts) out.push_back({{"name", one.name}, {"text", one.text}});
  return out;
}

}  // namespace

std::string encode_explanation(const ScanExplanation& explanation) {
  const std::string json = decisions_json(explanation).dump();
  const auto size = static_cast<std::uint32_t>(json.size());
  std::string out;
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>((size >> shift) & 0xFFU));
  out += json;
  append_points(out, explanation);
  for (std::size_t k = 0; k < explanation.gaps.size(); ++k) append_observations(out, explanation, k);
  return compress_zlib(out);
}

Json explanation_header(const VotingParameters& parameters, const DecisionLimits& limits) {
  Json figures = Json::object();
  for (const auto& [name, value] : limit_figures(parameters, limits)) figures[name] = value;
  return {{"observations", texts_json(kObservationTexts)},
          {"steps", texts_json(kPointTexts)},
          {"decisions", texts_json(kTrackTexts)},
          {"limits", std::move(figures)}};
}

}  // namespace mapless::app
