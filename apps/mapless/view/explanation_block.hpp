#pragma once

#include <string>

#include "reports/json.hpp"
#include <mapless/detection/explanation.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::app {

/// Why the points of a scan have their labels, as the page reads it (viewer/src/explanations.ts), compressed
/// (zlib). First the size of a JSON text (uint32) and the text: `gaps` of the reference scans, `votes` of
/// each of them by kind, and `objects`, the decisions about the proposed ones. Then, in the order of returns
/// of encode_scan; differences coded as there where `*`:
///
///     source      uint32 *, the return whose observations it has
///     step        uint8, PointStep, + 128: PointDecision::may_be_slow
///     proposed    uint16 *, number of the proposed object
///     support     uint16 *, supporters and near uint8: PointDecision; 0 where no text has them
///
/// and for each reference scan, of the returns with observations of their own,
///
///     kind        uint8, ObservationKind, + 16: agrees with a motion along the rays
///     distance    uint16, all low bytes first, of the kinds from `edge` on: how far before the point the
///                 nearest ray ends, of kinds of departed occluders how far these are from it; steps_of,
///                 times two, plus one if behind the point; 65535: not known
///     aside       uint8, steps_of, of the kinds of free space
[[nodiscard]] std::string encode_explanation(const ScanExplanation& explanation);

/// What the page's header says of all scans: the texts (reasons.hpp) and the limits in them.
[[nodiscard]] Json explanation_header(const VotingParameters& parameters, const DecisionLimits& limits);

}  // namespace mapless::app
