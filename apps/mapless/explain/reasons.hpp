#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <mapless/detection/explanation.hpp>

namespace mapless::app {

/// What a reference scan's rays say of a point, in the words of `kObservationTexts`.
enum class ObservationKind : std::uint8_t {
  not_queried,
  no_ray,
  faulty,
  edge,
  through,
  beside,
  nothing_met,
  surface,
  moving_surface,
  hidden,
  hider_stays,
  hider_left,
  hider_contradicted,
  slow_surface
};
inline constexpr std::size_t kObservationKinds = 14;

/// The step of segmentation that decided about a point.
enum class PointStep : std::uint8_t {
  own_vehicle,
  nothing_observed,
  static_votes,
  little_support,
  few_seeds,
  seed,
  spread,
  filled,
  tangential,
  body_completed,
  side_completed
};
inline constexpr std::size_t kPointSteps = 11;

/// A short name, for tables and colours, and a sentence. In braces are figures: {beyond}, {short}, {aside},
/// {distance} [m], {votes}, {support}, {supporters}, {near}, {reach}; of an object {evidence}, {required},
/// {displacement}, {speed}, {std}; and limits, see limit_figures. The page has the same texts.
struct ReasonText {
  std::string_view name, text;
};
extern const std::array<ReasonText, kObservationKinds> kObservationTexts;
extern const std::array<ReasonText, kPointSteps> kPointTexts;
inline constexpr std::size_t kTrackReasons = 12;
extern const std::array<ReasonText, kTrackReasons> kTrackTexts;

/// Distances in texts, and in the page: whole centimetres below 1 m, which are the steps 0 to 99, then whole
/// decimetres, the steps from 100 on. `metres` is not negative.
[[nodiscard]] int steps_of(double metres);
[[nodiscard]] std::string text_of_steps(int steps);

[[nodiscard]] ObservationKind kind_of(const Observation& observation, const DecisionLimits& limits);
[[nodiscard]] PointStep step_of(const PointDecision& point, const DecisionLimits& limits);

}  // namespace mapless::app
