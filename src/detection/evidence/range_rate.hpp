#pragma once

#include <span>

namespace mapless::inline v1 {

/// What one reference scan measured along the ray that passed nearest to a point of the query scan.
struct RangeOffset {
  int gap = 1;            ///< how many scans before the query scan; below 0 later
  float short_by_m = 0;   ///< how far before the point the ray ended; below 0 beyond it
  float aside_m = 0;      ///< how far from the point the ray passed
  int surface_votes = 0;  ///< of this scan against the point
  bool agrees = false;    ///< with the motion that moves_along_rays found
};

/// Whether the offsets of one point show a surface that moves steadily along the rays. A static surface has
/// the same range in every scan. A surface that recedes by u metres a scan ended u k before the point k scans
/// ago. Least squares over ten scans give u to a few millimetres, long before the point leaves the tolerance
/// of any one scan. `range_std_m`: standard deviation of an offset on a surface square to the ray. `slope`:
/// change of the surface's range per metre across the ray. If true, RangeOffset::agrees is
/// entered; otherwise its content is not defined.
[[nodiscard]] bool moves_along_rays(std::span<RangeOffset> offsets, float range_std_m, float slope);

}  // namespace mapless
