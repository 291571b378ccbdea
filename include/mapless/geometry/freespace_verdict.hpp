#pragma once

#include <cmath>
#include <cstdint>

namespace mapless::inline v1 {

/// Where a point lies with respect to the rays of a scan (paper step 3). Every freespace check answers so.
enum class FreespaceVerdict : std::uint8_t {
  not_evaluated,
  inside,     ///< in freespace: the ray passes beyond the point
  border,     ///< on a surface: the ray ends at the point
  outside,    ///< hidden: the ray ends short of the point
  unobserved  ///< no ray passes near, or the nearest has no usable return
};

/// The kernel of every freespace check: a point at `range_m` along a ray that is known to have gone `ray_m`
/// (NaN: not known). `tolerance_m`: how far from the end of the ray the surface it hit may lie. All [m].
template <class Real>
[[nodiscard]] FreespaceVerdict compare_ranges(Real ray_m, Real range_m, Real tolerance_m) {
  if (std::isnan(ray_m)) return FreespaceVerdict::unobserved;
  if (ray_m < range_m - tolerance_m) return FreespaceVerdict::outside;
  return ray_m <= range_m + tolerance_m ? FreespaceVerdict::border : FreespaceVerdict::inside;
}

}  // namespace mapless
