#include "lidar/aligned_image.hpp"

#include <cmath>
#include <numbers>

namespace mapless::inline v1 {

AlignedImage::AlignedImage(const LidarScan& scan) : columns_(scan.columns) {
  const LidarModel& model = *scan.model;
  const double columns_per_rad = model.sign() * model.columns / (2 * std::numbers::pi);
  shift_.reserve(model.lasers.size());
  for (const Laser& laser : model.lasers) {
    shift_.push_back(static_cast<int>(std::lround(laser.azimuth_offset_rad * columns_per_rad)));
  }
}

}  // namespace mapless
