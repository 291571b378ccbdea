#pragma once

#include <cmath>
#include <cstdint>

namespace mapless {

/// Farther cubes do not fit the 21 bits an axis has.
inline constexpr double kFarthestCube = 1e6;

/// The cube a point lies in, of three coordinates in cubes. Floor, not truncation, which would make the cubes
/// at 0 twice as wide.
[[nodiscard]] inline std::uint64_t cube_key(double x, double y, double z) {
  const auto bits = [](double c) {
    const auto truncated = static_cast<int>(c);
    return static_cast<std::uint64_t>(truncated - (c < truncated ? 1 : 0)) & 0x1FFFFFu;
  };
  return bits(x) << 42 | bits(y) << 21 | bits(z);
}

/// False for NaN.
[[nodiscard]] inline bool has_cube(double x, double y, double z) {
  return std::abs(x) < kFarthestCube && std::abs(y) < kFarthestCube && std::abs(z) < kFarthestCube;
}

/// Where the cube begins on an axis (0 to 2), in cubes.
[[nodiscard]] inline int cube_begin(std::uint64_t key, int axis) {
  const auto bits = static_cast<std::int32_t>(key >> (42 - 21 * axis) & 0x1FFFFFu);
  return (bits ^ 0x100000) - 0x100000;  // the highest bit is the sign
}

/// Multiplicative hash. Only the high bits of the product depend on all bits of the key: shift by 64 less the
/// number of bits wanted.
[[nodiscard]] inline std::size_t cube_slot(std::uint64_t key, int shift) {
  return static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> shift);
}

}  // namespace mapless
