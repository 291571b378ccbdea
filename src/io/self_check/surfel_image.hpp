#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lidar/aligned_image.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// A return with the normal of its surface, in the sensor frame at its own instant.
struct Surfel {
  Eigen::Vector3d position_v;  ///< [m]
  Eigen::Vector3d normal_v;
  double fraction;  ///< of the scan's duration, at its instant: 0 at its start, 1 at its end
};

/// Poses of the sensor within one scan, world from sensor, at instants evenly spaced from its start to its
/// end. A pose between two of them is that of the nearer: half of 1/64 of a turn at 20 m/s is 16 mm.
struct ScanPoses {
  static constexpr int kInstants = 65;
  std::vector<SE3> T_0v;  ///< kInstants of them

  [[nodiscard]] const SE3& at(double fraction) const;
};

/// A scan, to look up the surface that its rays saw at a place.
class SurfelImage {
 public:
  explicit SurfelImage(const LidarScan& scan);

  [[nodiscard]] double duration_s() const { return duration_s_; }
  [[nodiscard]] Time start() const { return scan_.start; }
  /// Up to `most` returns with normals, evenly over the directions of the normals: the ground, which is most
  /// of a scan and tells nothing of a motion along it, gets its share only.
  [[nodiscard]] std::vector<Surfel> sample(std::size_t most) const;
  /// What the rays that pass near a place say of it.
  struct Sight {
    std::optional<Surfel> surfel;  ///< the nearest one within reach
    bool free = false;             ///< all of them end well beyond the place
  };
  /// Of the place `p_0`, the scan having been at `poses`.
  [[nodiscard]] Sight look(const Eigen::Vector3d& p_0, const ScanPoses& poses, double reach_m) const;

 private:
  [[nodiscard]] const LidarReturn* at(int row, int aligned) const;
  [[nodiscard]] std::optional<Surfel> surfel_at(const LidarReturn& r) const;
  [[nodiscard]] double fraction(const LidarReturn& r) const;
  [[nodiscard]] int nearest_row(double elevation_rad) const;

  const LidarScan& scan_;
  AlignedImage image_;
  double duration_s_;
  int across_ = 1;  // columns between neighbours of which a normal is made
};

}  // namespace mapless
