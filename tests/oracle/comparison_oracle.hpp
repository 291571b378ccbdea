#pragma once

#include <vector>

#include <Eigen/Core>

#include <mapless/detection/parameters.hpp>

namespace mapless::test {

/// What step 2 measures for one point of the query scan.
struct OracleComparison {
  bool compared = false;  ///< false: no reference point, or no normal too far away
  double error_m = 0;     ///< |n . (p - q)| with a normal n, else ||p - q||, to the nearest reference point p
};

/// Paper step 2, with every reference point looked at. `normal_0` is zero where the point has none.
[[nodiscard]] OracleComparison comparison_error(const Eigen::Vector3d& q_0, const Eigen::Vector3f& normal_0,
                                                double range_m,
                                                const std::vector<Eigen::Vector3d>& reference_0,
                                                const ComparisonParameters& parameters);

}  // namespace mapless::test
