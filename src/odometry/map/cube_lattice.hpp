#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "odometry/map/cube_hash.hpp"

namespace mapless::inline v1 {

/// Space in cubes with sides of `cube_m`, one corner at (offset_m, offset_m, offset_m).
class CubeLattice {
 public:
  CubeLattice(double cube_m, double offset_m)
      : cube_m_(cube_m), cubes_per_m_(1 / cube_m), offset_m_(offset_m), middle_m_(offset_m + cube_m / 2) {}

  [[nodiscard]] double cube_m() const { return cube_m_; }
  /// The key of the cube of a point; kNoCube if it is farther than 2^20 cubes from the origin, and for NaN.
  [[nodiscard]] std::uint64_t key_of(const Eigen::Vector3d& p_0) const {
    return cube_key(in_cubes(p_0.x()), in_cubes(p_0.y()), in_cubes(p_0.z()));
  }
  [[nodiscard]] Eigen::Vector3d corner_of(std::uint64_t key) const {
    const Eigen::Vector3d number(cube_number(key, 0), cube_number(key, 1), cube_number(key, 2));
    return (cube_m_ * number).array() + offset_m_;
  }
  /// Distance of a point from the nearest face of its cube [m].
  [[nodiscard]] double distance_to_face(const Eigen::Vector3d& p_0) const {
    const auto off = [&](double p) {
      const double at = in_cubes(p);
      return std::abs(at - nearest_integer(at));
    };
    return cube_m_ * (0.5 - std::max({off(p_0.x()), off(p_0.y()), off(p_0.z())}));
  }

 private:
  // In cube sides, from the middle of the cube whose corner is the offset.
  [[nodiscard]] double in_cubes(double coordinate) const { return (coordinate - middle_m_) * cubes_per_m_; }

  double cube_m_, cubes_per_m_, offset_m_, middle_m_;
};

}  // namespace mapless
