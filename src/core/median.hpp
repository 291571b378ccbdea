#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace mapless::inline v1 {

/// The median; of an even number of values the upper of the middle two. `values` must not be empty.
template <typename T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace mapless
