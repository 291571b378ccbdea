#pragma once

#include <cstddef>
#include <string_view>

namespace mapless::inline v1 {

/// Throws ParameterError for a range limit that is not in (0, 1e6] m.
void require_range_limit(std::string_view function, double max_range_m);

/// Throws InputError unless a scan of `points` true labels has as many predicted labels and ranges.
void require_equal_lengths(std::size_t scan, std::size_t points, std::size_t results, std::size_t ranges);

}  // namespace mapless
