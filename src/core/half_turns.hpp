#pragma once

#include <array>
#include <cstddef>

namespace mapless::inline v1 {

/// Sums over every half turn, by its first sector, of numbers that are given by azimuth, the turn in equal
/// sectors. One vehicle beside the sensor is within one half turn: a plane separates it from the sensor.
template <class Number, std::size_t sectors>
std::array<Number, sectors> half_turns(const std::array<Number, sectors>& numbers) {
  std::array<Number, sectors> sums{};
  for (std::size_t first = 0; first < sectors; ++first) {
    for (std::size_t i = first; i < first + sectors / 2; ++i) sums[first] += numbers[i % sectors];
  }
  return sums;
}

}  // namespace mapless
