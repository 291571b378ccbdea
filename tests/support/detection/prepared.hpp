#pragma once

#include <memory>
#include <utility>

#include "detection/published/prepared_scan.hpp"
#include "geometry/nearest_neighbours.hpp"

namespace mapless::test {

/// What the detector makes of a scan before the stages look at it.
inline PreparedScan prepare(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory,
                            const NormalParameters& parameters = {}) {
  CompensatedScan compensated = compensate(std::move(scan), trajectory);
  NearestNeighbours neighbours(compensated.points_0);
  std::vector<Eigen::Vector3f> normals = estimate_normals(compensated, neighbours, parameters);
  return {std::move(compensated), std::move(neighbours), std::move(normals)};
}

}  // namespace mapless::test
