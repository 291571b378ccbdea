#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace mapless::inline v1 {

// Keys of cubes in an unbounded grid, 21 bits per axis, and their hash.

/// The key of no cube: the keys of cubes have 63 bits.
inline constexpr std::uint64_t kNoCube = ~std::uint64_t{0};

/// Half the number of cubes along an axis: 2^21 cubes, 21 bits.
inline constexpr int kHalfAxis = 1 << 20;
/// Adding it rounds a number to an integer, because a double of at least 2^52 has no fractional bits; the
/// offset makes the integer non-negative.
inline constexpr double kRoundToInteger = 0x1p52 + kHalfAxis;

/// The nearest integer to a coordinate between -kHalfAxis and kHalfAxis.
[[nodiscard]] inline double nearest_integer(double c) { return (c + kRoundToInteger) - kRoundToInteger; }

/// The key of the cube that contains a point. The coordinates are in cube sides, from the middle of cube 0.
/// kNoCube for a point farther than half an axis, and for NaN.
[[nodiscard]] inline std::uint64_t cube_key(double x, double y, double z) {
  const auto number = [](double c) {
    return std::bit_cast<std::uint64_t>(c + kRoundToInteger) - std::bit_cast<std::uint64_t>(0x1p52);
  };
  const std::uint64_t nx = number(x), ny = number(y), nz = number(z);
  return (nx | ny | nz) >> 21 == 0 ? nx << 42 | ny << 21 | nz : kNoCube;
}

/// The number of a cube along an axis (0 to 2), between -kHalfAxis and kHalfAxis.
[[nodiscard]] inline int cube_number(std::uint64_t key, int axis) {
  return static_cast<int>(key >> (42 - 21 * axis) & 0x1FFFFFu) - kHalfAxis;
}

/// Slot of a key in a table of 2^n slots, with `shift` = 64 - n. Multiplicative hash with 2^64 / golden ratio
/// (Knuth, TAOCP vol. 3, 6.4): only the high bits of the product depend on all bits of the key.
inline constexpr std::uint64_t kGoldenRatio64 = 0x9E3779B97F4A7C15u;
[[nodiscard]] inline std::size_t cube_slot(std::uint64_t key, int shift) {
  return static_cast<std::size_t>(key * kGoldenRatio64 >> shift);
}

}  // namespace mapless
