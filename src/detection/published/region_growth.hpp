#pragma once

#include <cstdint>
#include <vector>

#include "detection/published/prepared_scan.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

struct RegionGrowthResult {
  std::vector<GrowthVerdict> verdict;  ///< one per return
  std::vector<std::uint16_t>
      object;  ///< 0: static; else 1, 2, ... 65535 (shared beyond), by lowest return index
  int objects = 0;
};

/// Step 5: radially bounded nearest neighbour clusters of the dynamic points (Klasing et al., ICRA 2008): two
/// of them are linked within link_m + link_per_m x range of the nearer. Clusters of fewer than
/// min_cluster_points are too small. The others are seeds: they grow over linked points that are parallel or
/// convex to them, n1.(p2-p1) <= tolerance and n2.(p1-p2) <= tolerance (Moosmann et al., IV 2009; tolerance =
/// ||p2-p1|| sin(concave_tolerance_deg)), both with a normal, and no farther than
/// max_growth_m from the nearest seed. What is linked is one object. The answer does not depend on any order.
/// `dynamic` has one element per return.
[[nodiscard]] RegionGrowthResult grow_regions(const PreparedScan& scan, const std::vector<char>& dynamic,
                                              const RegionGrowthParameters& parameters);

}  // namespace mapless
