#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::test {

/// What region growth looks at of one point.
struct OraclePoint {
  Eigen::Vector3d position_0;
  Eigen::Vector3f normal_0;  ///< zero: none
  double range_m;
  bool dynamic;
};

struct OracleObjects {
  std::vector<GrowthVerdict> verdict;
  std::vector<std::uint16_t> object;
  int objects = 0;
};

/// Paper step 5 by union-find over all pairs of points, as region_growth.hpp states it. Two points are linked
/// within link_m + link_per_m times the range of the nearer; unless both are seeds they must also both have a
/// normal and be parallel (normals within parallel_tolerance_deg) or convex to each other. Dynamic points of
/// clusters of fewer than min_cluster_points are no seeds; like static points they may be grown over.
[[nodiscard]] OracleObjects objects_by_pairs(const std::vector<OraclePoint>& points,
                                             const RegionGrowthParameters& parameters);

}  // namespace mapless::test
