#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

namespace mapless::inline v1 {

/// Counter-based random numbers: a pure function of the counters (seed, purpose, scan, laser, column ...).
/// Neither the number of threads nor the length of a run changes them. The mixing function is that of
/// splitmix64 (Steele, Lea, Flood, OOPSLA 2014), from which its constants are.
[[nodiscard]] inline std::uint64_t random_bits(std::initializer_list<std::uint64_t> counters) {
  std::uint64_t x = 0x243F6A8885A308D3u;  // start value: fractional bits of pi
  for (const std::uint64_t c : counters) {
    x = (x ^ c) + 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    x ^= x >> 31;
  }
  return x;
}

/// Maps 64 random bits to (0, 1].
[[nodiscard]] inline double unit_number(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 1) * 0x1p-53;
}

/// The sequence of random numbers of one purpose, for objects that are built once and in a fixed order (a
/// house, a route).
class RandomSequence {
 public:
  RandomSequence(std::uint64_t seed, std::uint64_t purpose) : seed_(seed), purpose_(purpose) {}
  [[nodiscard]] double uniform(double low, double high) {
    return low + (high - low) * unit_number(random_bits({seed_, purpose_, counter_++}));
  }
  /// In [0, count).
  [[nodiscard]] int index(int count) {
    return static_cast<int>(random_bits({seed_, purpose_, counter_++}) % static_cast<std::uint64_t>(count));
  }
  /// True with this probability.
  [[nodiscard]] bool chance(double probability) { return uniform(0, 1) <= probability; }

 private:
  std::uint64_t seed_, purpose_, counter_ = 0;
};

}  // namespace mapless
