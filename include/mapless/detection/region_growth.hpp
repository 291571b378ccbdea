#pragma once

#include <cstdint>
#include <vector>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/prepared_scan.hpp>
#include <mapless/detection/stages.hpp>

namespace mapless {

struct RegionGrowthResult {
  std::vector<GrowthVerdict> verdict;  ///< one per return
  std::vector<std::uint16_t> object;   ///< 0: static; else 1, 2, ... by the lowest return index of the object
  int objects = 0;
};

/// Step 5: radially bounded nearest neighbour clusters of the dynamic points (Klasing et al., ICRA 2008); clusters of at
/// least min_cluster_points grow over linked points that are parallel or convex to them, n1.(p2-p1) <= 0 and
/// n2.(p1-p2) <= 0 (Moosmann et al., IV 2009), no farther than max_growth_m from a seed; clusters that meet are one
/// object. The answer does not depend on any order. `dynamic` has one element per return.
[[nodiscard]] RegionGrowthResult grow_regions(const PreparedScan& scan, const std::vector<char>& dynamic,
                                              const RegionGrowthParameters& parameters);

}  // namespace mapless
