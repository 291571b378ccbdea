#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "lidar/aligned_image.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// How far off the plane of a surface a ray of another scan ended.
struct PlaneOffset {
  Eigen::Vector3d normal_0;
  double off_m = 0;     ///< along the normal
  double before_s = 0;  ///< how long before the scan of the surface that was; below 0: after it
};

/// A velocity and its standard deviation in the direction in which it is known worst.
struct SlowMotion {
  Eigen::Vector3d velocity_0;
  double std_mps = 0;
};

/// The velocity with which a surface has moved to its planes from where the rays of the scans about it ended,
/// by least squares with Cauchy weights. It holds for a surface that went by less than its planes are wide:
/// each ray belongs to the plane that it passes now.
[[nodiscard]] SlowMotion slow_motion(std::span<const PlaneOffset> offsets);

/// Normals of the surfaces that a scan hit, from the returns about a decimetre away in the scan image.
class SurfaceNormals {
 public:
  /// Keeps references. `points`: one per return of the scan.
  SurfaceNormals(const LidarScan& scan, const std::vector<Eigen::Vector3f>& points);

  /// Of return i, of either sign; 0 where its neighbours are missing or beyond an edge.
  [[nodiscard]] Eigen::Vector3d of(std::size_t i) const;

 private:
  [[nodiscard]] Eigen::Vector3d across(std::size_t i, int rows, int columns) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  AlignedImage image_;
  double row_rad_, column_rad_;  // mean angles between neighbouring lasers, and firings
};

}  // namespace mapless
