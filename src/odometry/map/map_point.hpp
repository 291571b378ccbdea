#pragma once

#include <Eigen/Core>

namespace mapless::inline v1 {

struct MapPoint {
  Eigen::Vector3d p_0;  ///< [m]
  unsigned laser;
  double range_m;     ///< from the sensor
  unsigned pass = 0;  ///< a cube without room for all points takes those of lower passes first
  unsigned scan = 0;  ///< any number that other scans do not have
};

}  // namespace mapless
