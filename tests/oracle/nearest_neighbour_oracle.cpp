#include "oracle/nearest_neighbour_oracle.hpp"

namespace mapless::test {

OracleNeighbour nearest_by_exhaustion(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& q) {
  OracleNeighbour best;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = (points[i] - q).norm();
    if (best.index < 0 || distance < best.distance_m) best = {static_cast<int>(i), distance};
  }
  return best;
}

}  // namespace mapless::test
