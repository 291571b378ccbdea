#include "detection/evidence/slope_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mapless::inline v1 {

SurfaceSlopes SlopeImage::of(std::size_t i, int columns) const {
  const int laser = scan_.returns[i].laser;
  return {std::min(towards(i, laser - 1, 0), towards(i, laser + 1, 0)),
          std::min(towards(i, laser, -columns), towards(i, laser, columns))};
}

// By how much the range changes per metre across the ray, from return i to a neighbour.
float SlopeImage::towards(std::size_t i, int row, int columns) const {
  if (row < 0 || row >= scan_.rows()) return SurfaceSlopes::kUnknown;
  const LidarReturn& r = scan_.returns[i];
  const std::int32_t n =
      scan_.cell(row, image_.scan_column(row, image_.aligned_column(r.laser, r.column) + columns));
  if (n < 0) return SurfaceSlopes::kUnknown;
  const auto j = static_cast<std::size_t>(n);
  const float deeper_m = std::abs(scan_.returns[j].range_m - r.range_m);
  const float across2 = (points_[j] - points_[i]).squaredNorm() - deeper_m * deeper_m;
  return across2 > 0 ? deeper_m / std::sqrt(across2) : SurfaceSlopes::kUnknown;
}

}  // namespace mapless
