#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace mapless::inline v1 {

/// The key of no cube; those of cubes have 63 bits.
inline constexpr std::uint64_t kNoCube = ~std::uint64_t{0};

/// Half as many cubes as an axis has, which fit 21 bits; and what makes a number of that size whole by adding
/// it: no double of the sum's size has a fraction.
inline constexpr int kHalfAxis = 1 << 20;
inline constexpr double kMakesWhole = 0x1p52 + kHalfAxis;

/// The nearest whole number, of one that has a cube.
[[nodiscard]] inline double nearest_whole(double c) { return (c + kMakesWhole) - kMakesWhole; }

/// The cube a point lies in, of three coordinates in cubes from the middle of the one at 0. kNoCube for what
/// is farther than half an axis, and for NaN.
[[nodiscard]] inline std::uint64_t cube_key(double x, double y, double z) {
  const auto number = [](double c) {
    return std::bit_cast<std::uint64_t>(c + kMakesWhole) - std::bit_cast<std::uint64_t>(0x1p52);
  };
  const std::uint64_t nx = number(x), ny = number(y), nz = number(z);
  return (nx | ny | nz) >> 21 == 0 ? nx << 42 | ny << 21 | nz : kNoCube;
}

/// The number of a cube on an axis (0 to 2).
[[nodiscard]] inline int cube_number(std::uint64_t key, int axis) {
  return static_cast<int>(key >> (42 - 21 * axis) & 0x1FFFFFu) - kHalfAxis;
}

/// Multiplicative hash. Only the high bits of the product depend on all bits of the key: shift by 64 less the
/// number of bits wanted.
[[nodiscard]] inline std::size_t cube_slot(std::uint64_t key, int shift) {
  return static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> shift);
}

}  // namespace mapless
