#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/formats/pcd/pcd_points.hpp"
#include "lidar/model_estimation.hpp"
#include "lidar/ring_recovery.hpp"

namespace mapless::inline v1 {

/// What tells the ring of a point.
enum class PcdRingSource {
  field,  ///< a field of the file
  rows,   ///< the rows of an organised cloud
  order,  ///< the order of the points: ring after ring, as KITTI stores them
};

/// The sensor of a PCD folder that does not come with one.
struct PcdSensor {
  LidarModel model;
  BareCloudLayout layout;
  ModelEstimate estimate;
  PcdRingSource rings_from = PcdRingSource::order;
  std::size_t rows = 1;                    ///< of the clouds
  std::vector<std::int64_t> ring_numbers;  ///< of the file, in the order of layout.row_of_ring
  std::vector<std::string> notes;          ///< how it was found, one line each
};

/// Estimates the sensor from a few scans: rings by `field`, else `rows`, else `order`; spin from the times of
/// the points, else from the starts of the scans, clockwise. Throws InputError that asks for the sensor where
/// the rings found are not those of a spinning lidar.
[[nodiscard]] PcdSensor estimate_pcd_sensor(const std::vector<std::filesystem::path>& files,
                                            const std::vector<Time>& starts, const std::string& folder);

/// Row of every point of a scan. Throws InputError naming `source` where the scan has other rings.
[[nodiscard]] std::vector<std::int32_t> lasers_by_rings(const PcdPoints& points, const PcdSensor& sensor,
                                                        const std::string& source);

}  // namespace mapless
