#pragma once

#include <vector>

#include <Eigen/Core>

#include "geometry/nearest_neighbours.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// This folder is the method as published (arXiv 1809.06972), stage by stage, for comparison and for tests.
/// In: scans with their trajectory (make_published_pipeline). Out: object proposals with the verdict of each
/// stage. Its stages are free functions on const input; nothing outside calls them but tests and benchmarks.
///
/// PreparedScan: what the stages need of one scan, computed once when it arrives.
struct PreparedScan {
  CompensatedScan compensated;
  NearestNeighbours neighbours;            ///< of compensated.points_0
  std::vector<Eigen::Vector3f> normals_0;  ///< estimate_normals of compensated

  [[nodiscard]] const LidarScan& scan() const { return *compensated.scan; }
};

}  // namespace mapless
