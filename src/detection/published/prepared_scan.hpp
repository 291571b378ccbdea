#pragma once

#include <vector>

#include <Eigen/Core>

#include "geometry/nearest_neighbours.hpp"
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/geometry/normals.hpp>

namespace mapless::inline v1 {

/// What the stages need of one scan, computed once when it arrives.
struct PreparedScan {
  CompensatedScan compensated;
  NearestNeighbours neighbours;            ///< of compensated.points_0
  std::vector<Eigen::Vector3f> normals_0;  ///< estimate_normals of compensated

  [[nodiscard]] const LidarScan& scan() const { return *compensated.scan; }
};

}  // namespace mapless
