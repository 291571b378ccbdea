#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "detection/freespace/freespace_probe.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {

/// How the surfaces that a scan hit are inclined to its rays, from the neighbours of a return in the scan
/// image. Of the two neighbours on either side the less inclined one counts, since the other may lie beyond
/// an edge. Where both are missing the slope is unknown.
class SlopeImage {
 public:
  /// Keeps references. `points`: one per return of the scan.
  SlopeImage(const LidarScan& scan, const std::vector<Eigen::Vector3f>& points)
      : scan_(scan), points_(points), image_(scan) {}

  /// Of return i; to the side from neighbours `columns` away.
  [[nodiscard]] SurfaceSlopes of(std::size_t i, int columns) const;

 private:
  [[nodiscard]] float towards(std::size_t i, int row, int columns) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  AlignedImage image_;
};

}  // namespace mapless
