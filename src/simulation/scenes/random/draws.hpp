#pragma once

#include <initializer_list>
#include <utility>

#include "simulation/random.hpp"

namespace mapless::inline v1 {

/// One of the values, each with the probability weight / sum of the weights.
template <typename T>
[[nodiscard]] T draw_one(RandomSequence& random, std::initializer_list<std::pair<T, double>> weighted) {
  double left = 0;
  for (const auto& [value, weight] : weighted) left += weight;
  left *= random.uniform(0, 1);
  for (const auto& [value, weight] : weighted) {
    left -= weight;
    if (left <= 0) return value;
  }
  return weighted.begin()->first;
}

/// A whole number from `low` to `high`.
[[nodiscard]] inline int draw_count(RandomSequence& random, int low, int high) {
  return low + random.index(high - low + 1);
}

}  // namespace mapless
