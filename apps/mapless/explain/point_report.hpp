#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "options/parameter_options.hpp"
#include "reports/json.hpp"
#include <mapless/detection/explanation.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {

/// The decisions about an object over the scans of a run, by the number of the scan.
using ObjectHistory = std::map<std::size_t, ObjectDecision>;

/// A point to be explained, with all that is said of it.
struct ExplainedPoint {
  std::size_t scan = 0;                    ///< number in the recording
  std::size_t at = 0;                      ///< its return
  const LabelledScan* labelled = nullptr;  ///< with the explanation of its points
  ObjectHistory history;                   ///< of its proposed object; empty: it has none
};

/// What the texts call limits: their names and values as text (reasons.hpp).
using Figures = std::map<std::string, std::string>;
[[nodiscard]] Figures limit_figures(const VotingParameters& parameters, const DecisionLimits& limits);

/// `text` with the figures in place of their names in braces.
[[nodiscard]] std::string filled_in(std::string_view text, const Figures& figures);

/// The decision about a proposed object in words.
[[nodiscard]] std::string decision_text(const ObjectDecision& decision, Figures figures);

/// Why the point is dynamic or static: JSON with every figure, and a text of some 30 lines.
[[nodiscard]] Json point_json(const ExplainedPoint& point, const VotingParameters& parameters);
[[nodiscard]] std::string point_text(const Json& point);

}  // namespace mapless::app
