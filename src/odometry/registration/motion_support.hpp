#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <mapless/odometry/odometry_update.hpp>

namespace mapless::inline v1 {

/// Whether the points of the last scans support the motion found. A wrong motion keeps the points that agree
/// with any motion along them (ground, barriers, walls) and loses those that constrain it (poles, trees,
/// corners): fewer points agree, and the weakest direction is constrained less. Where planes constrain a
/// right motion little, as along a motorway, its edges agree from scan to scan.
class MotionSupport {
 public:
  /// Adds a registered scan: OdometryUpdate::mean_robust_weight, and the smallest constraint ratio.
  void add(double mean_robust_weight, const Degeneracy& degeneracy);
  /// Whether the planes alone leave the state open. Then add_edges() is of use.
  [[nodiscard]] bool needs_edges() const;
  /// Adds edge_agreement() of the scan last added.
  void add_edges(double agreement);
  /// By the means over the last scans: good if the planes support the motion, or if the edges and many points
  /// do. A young map has few planes, and supports a right motion less: where its support is small but not
  /// tiny, the state is degenerate. Good before the first scan.
  [[nodiscard]] MotionState state() const;

 private:
  /// Scans of the means. Measured: see motion_support.cpp.
  static constexpr std::size_t kScans = 5;
  using Last = std::array<double, kScans>;
  [[nodiscard]] double mean(const Last& last) const;

  Last support_{};
  Last weight_{};
  std::optional<double> edge_agreement_;  // while needs_edges(): a mean that forgets over kScans
  std::size_t added_ = 0;
};

}  // namespace mapless
