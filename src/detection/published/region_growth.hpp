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
/// min_cluster_points are too small. The points of the others are seeds. Regions grow from the seeds over
/// linked points with a normal, no farther than max_growth_m from the nearest seed, that are parallel or
/// convex to a point of the region (Moosmann et al., IV 2009). Parallel: n1.n2 >=
/// cos(parallel_tolerance_deg). Convex: n1.(p2-p1) <= tolerance and n2.(p1-p2) <= tolerance, tolerance =
/// ||p2-p1|| sin(concave_tolerance_deg). A connected region is one object. The answer does not depend on any
/// order. The time is that of finding each point once in a k-d tree. `dynamic` has one element per return.
[[nodiscard]] RegionGrowthResult grow_regions(const PreparedScan& scan, const std::vector<char>& dynamic,
                                              const RegionGrowthParameters& parameters);

}  // namespace mapless
