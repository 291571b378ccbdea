#pragma once

#include <cstddef>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// Throws InputError naming the first of the scans [first, first + count) that does not start after the one
/// before it. The detector refuses it too, but only when it gets there, and without the file.
void require_time_order(const Dataset& dataset, std::size_t first, std::size_t count);

}  // namespace mapless
