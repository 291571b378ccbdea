#pragma once

#include <string_view>

#include <mapless/evaluation/evaluator.hpp>

namespace mapless::inline v1 {

/// Throws ParameterError for a range limit that is not in (0, 1e6] m.
void require_range_limit(std::string_view function, double max_range_m);

/// Throws InputError if the spans of the scan differ in length.
void require_equal_lengths(const LabelledScan& scan);

}  // namespace mapless
