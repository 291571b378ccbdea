#pragma once

#include <vector>

#include <Eigen/Core>

#include "oracle/ray_search_oracle.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::test {

struct OracleFreespace {
  FreespaceVerdict verdict = FreespaceVerdict::unobserved;
  /// How near the answer was to another one [m]: the least difference between two lengths that were compared.
  double margin_m = 0;
};

/// Paper step 3 from its geometry, with the nearest ray by brute force and each endpoint from its own
/// instant's pose.
class FreespaceOracle {
 public:
  FreespaceOracle(const LidarScan& reference, const Trajectory& trajectory);
  /// `normal_0` is zero where the point has none.
  [[nodiscard]] OracleFreespace verdict(const Eigen::Vector3d& q_0, const Eigen::Vector3d& normal_0,
                                        double threshold_m, const FreespaceParameters& parameters) const;

 private:
  [[nodiscard]] double spacing_at(int laser) const;
  [[nodiscard]] int image_column(int laser, int column) const;

  const LidarScan& reference_;
  RaySearchOracle rays_;
  std::vector<Eigen::Vector3d> endpoints_0_;
};

}  // namespace mapless::test
