#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace mapless {

/// Farther cubes do not fit the 21 bits an axis has.
inline constexpr double kFarthestCube = 1e6;

[[nodiscard]] inline bool has_cube(const Eigen::Vector3d& p, double cube_m) {
  const double most = kFarthestCube * cube_m;
  return std::abs(p.x()) < most && std::abs(p.y()) < most && std::abs(p.z()) < most;  // false for NaN
}

/// The cube a point lies in. Floor, not truncation, which would make the cubes at 0 twice as wide.
[[nodiscard]] inline Eigen::Array3i cube_of(const Eigen::Vector3d& p, double cubes_per_m) {
  const Eigen::Array3d at = p.array() * cubes_per_m;
  const Eigen::Array3i truncated = at.cast<int>();
  return truncated - (at < truncated.cast<double>()).cast<int>();
}

[[nodiscard]] inline std::uint64_t cube_key(const Eigen::Array3i& cube) {
  const auto bits = [](int c) { return static_cast<std::uint64_t>(c) & 0x1FFFFFu; };
  return bits(cube.x()) << 42 | bits(cube.y()) << 21 | bits(cube.z());
}

[[nodiscard]] inline Eigen::Array3i cube_of_key(std::uint64_t key) {
  const auto axis = [&](int bit) {
    const auto bits = static_cast<std::int32_t>(key >> bit & 0x1FFFFFu);
    return (bits ^ 0x100000) - 0x100000;  // the highest bit is the sign
  };
  return {axis(42), axis(21), axis(0)};
}

/// Multiplicative hash. Only the high bits of the product depend on all bits of the key: shift by 64 less the
/// number of bits wanted.
[[nodiscard]] inline std::size_t cube_slot(std::uint64_t key, int shift) {
  return static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> shift);
}

}  // namespace mapless
