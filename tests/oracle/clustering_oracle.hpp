#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>

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

/// Paper step 5 by union-find over all pairs of points. Two points are linked within link_m + link_per_m times the range
/// of the nearer; unless both are dynamic they must also both have a normal and be parallel or convex to each other, to
/// within `convex_tolerance_m` [m]. Dynamic points linked to fewer than min_cluster_points in all are too small.
/// The others reach every point linked to them through points no farther than max_growth_m from one of them.
[[nodiscard]] OracleObjects objects_by_pairs(const std::vector<OraclePoint>& points,
                                             const RegionGrowthParameters& parameters, double convex_tolerance_m);

}  // namespace mapless::test
