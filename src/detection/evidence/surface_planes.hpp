#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "geometry/plane_fit.hpp"
#include "lidar/aligned_image.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// The planes of the surfaces that a scan hit, each from the returns around one of its points.
///
/// A ray that meets a surface at a small angle ends well before or behind a point of it although it hit the
/// same surface: at 15 degrees a step of 3 cm, of ground that is not quite level or the edge of a door, is 12
/// cm along the ray. Along the normal it stays 3 cm.
class SurfacePlanes {
 public:
  /// Keeps references. `points`: one per return of the scan [m]. `tolerance_m`: four standard deviations of a
  /// range.
  SurfacePlanes(const LidarScan& scan, const std::vector<Eigen::Vector3f>& points, float tolerance_m)
      : scan_(scan), points_(points), image_(scan), tolerance_m_(tolerance_m) {}

  /// Whether `place`, at most kReach_m from return i, lies in the plane of its surface to within two standard
  /// deviations of a range. No where the returns around it are no plane.
  [[nodiscard]] bool contains(std::size_t i, const Eigen::Vector3f& place) const;

  static constexpr float kReach_m = 1;  // chosen: a surface farther away is another part of the body

 private:
  // The returns around one of them, about its point.
  struct Surroundings {
    Moments moments;
    bool other_lasers = false;  // than that of the return
  };
  [[nodiscard]] float radius_m(const LidarReturn& r) const;
  [[nodiscard]] Surroundings around(std::size_t i) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  AlignedImage image_;
  float tolerance_m_;
};

}  // namespace mapless
