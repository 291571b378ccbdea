#pragma once

#include <Eigen/Core>
#include <vector>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {

/// A cell of a scan seen as the ray that was fired there.
struct NearestRay {
  int laser = -1;  ///< -1: the scan has no ray
  int column = -1;
  double distance_m = 0;        ///< of the point from the ray's line
  double range_m = 0;           ///< of the point's foot along the ray, from the ray's own origin
  [[nodiscard]] bool found() const { return laser >= 0; }
};

/// Finds the measured ray of one scan that passes nearest to a point: over lasers l and time t it minimises ||e_l(t)||,
/// e_l(t) = D T_lh T_hv(t) T_v0(t) [q; 1] (paper Eq. 1 and 2), then takes the measured ray closest in time. Each ray has
/// its laser's own pose and its own instant. Cells where the recording has no firing (ReturnCode::absent) are passed
/// over. Of equally near rays the lower laser, then the lower column.
class RaySearch {
 public:
  /// Keeps a reference to `scan`. `look_ahead` as FreespaceParameters::look_ahead_lasers.
  RaySearch(const CompensatedScan& scan, int look_ahead);

  /// `q_0`: a point in the world frame [m].
  [[nodiscard]] NearestRay nearest(const Eigen::Vector3d& q_0) const;

 private:
  struct LaserPose {
    SE3 T_lh;
    double elevation_rad;
  };
  const CompensatedScan& scan_;
  int look_ahead_;
  std::vector<LaserPose> lasers_;
};

}  // namespace mapless
