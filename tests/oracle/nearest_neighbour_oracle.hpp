#pragma once

#include <vector>

#include <Eigen/Core>

namespace mapless::test {

struct OracleNeighbour {
  int index = -1;
  double distance_m = 0;
};

/// Every point looked at; of equally near ones the lowest index. Index -1 for no points.
[[nodiscard]] OracleNeighbour nearest_by_exhaustion(const std::vector<Eigen::Vector3d>& points,
                                                    const Eigen::Vector3d& q);

}  // namespace mapless::test
