#pragma once

#include <filesystem>
#include <random>
#include <vector>

#include <Eigen/Core>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::test {

using Cloud = std::vector<Eigen::Vector3f>;

/// A made-up HDL-64E-like sensor, clockwise with its seam at the rear: `lasers` from -20 to +2 degrees,
/// vertical origins in two blocks, horizontal origins +-0.026 m and azimuth offsets up to 9 degrees.
[[nodiscard]] LidarModel make_bare_cloud_model(int lasers, int columns);

/// One turn in a courtyard with uneven walls and flat ground, as KITTI stores it: hits only, ring after ring
/// from the top, each by azimuth from the front. With `encoder_steps` the hub's angle is read off an encoder
/// (rounded down to one of that many positions), otherwise columns are evenly spaced. `scale` makes another
/// courtyard.
[[nodiscard]] Cloud make_bare_cloud(const LidarModel& model, int encoder_steps, double scale = 1);

/// Writes a cloud as KITTI's .bin, reflectance 0.
void write_kitti_cloud(const std::filesystem::path& file, const Cloud& cloud);

}  // namespace mapless::test
