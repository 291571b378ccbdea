#pragma once

#include <array>
#include <cstddef>

#include <mapless/odometry/odometry_update.hpp>

namespace mapless::inline v1 {

/// Whether the points of the last scans support the motion found. A wrong motion keeps the points that agree
/// with any motion along them (ground, barriers, walls) and loses those that constrain it (poles, trees,
/// corners): fewer points agree, and the weakest direction is constrained less.
class MotionSupport {
 public:
  /// Adds a registered scan: OdometryUpdate::mean_robust_weight, and the smallest constraint ratio.
  void add(double mean_robust_weight, const Degeneracy& degeneracy);
  /// By the means over the last scans. A young map has few planes, and supports a right motion less: where
  /// its support is small but not tiny, the state is degenerate. Good before the first scan.
  [[nodiscard]] MotionState state() const;

 private:
  /// Scans of the means. Measured: see motion_support.cpp.
  static constexpr std::size_t kScans = 5;
  std::array<double, kScans> support_{};
  std::size_t added_ = 0;
};

}  // namespace mapless
