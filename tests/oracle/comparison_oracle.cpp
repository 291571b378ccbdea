#include "oracle/comparison_oracle.hpp"

#include <cmath>

#include "oracle/nearest_neighbour_oracle.hpp"

namespace mapless::test {

OracleComparison comparison_error(const Eigen::Vector3d& q_0, const Eigen::Vector3f& normal_0, double range_m,
                                  const std::vector<Eigen::Vector3d>& reference_0,
                                  const ComparisonParameters& parameters) {
  const OracleNeighbour nearest = nearest_by_exhaustion(reference_0, q_0);
  if (nearest.index < 0) return {};
  const bool has_normal = normal_0.squaredNorm() > 0;
  if (!has_normal && range_m > parameters.max_range_without_normal_m) return {};
  const Eigen::Vector3d step = reference_0[static_cast<std::size_t>(nearest.index)] - q_0;
  return {true, has_normal ? std::abs(normal_0.cast<double>().dot(step)) : step.norm()};
}

}  // namespace mapless::test
