#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/formats/pcd/pcd_points.hpp"
#include "lidar/model_estimation.hpp"
#include "lidar/ring_recovery.hpp"

namespace mapless::inline v1 {

/// Source of the ring of a point.
enum class PcdRingSource {
  field,  ///< a field of the file
  rows,   ///< the row of an organised cloud
  order,  ///< the storage order: ring after ring, as in KITTI
};

/// The estimated sensor of a PCD folder.
struct PcdSensor {
  LidarModel model;
  BareCloudLayout layout;
  ModelEstimate estimate;
  PcdRingSource rings_from = PcdRingSource::order;
  std::size_t rows = 1;                    ///< number of rows of the clouds
  std::vector<std::int64_t> ring_numbers;  ///< ring numbers of the files, in the order of layout.row_of_ring
  std::vector<std::string> notes;          ///< how each property was estimated, one line each
};

/// Estimates the sensor from a few scans. Rings come from `field`, else `rows`, else `order`; rate and
/// direction of rotation from the times of the points, else from the starts of the scans (then clockwise).
/// Throws InputError, which suggests to name the sensor, if the rings are not those of a spinning lidar.
[[nodiscard]] PcdSensor estimate_pcd_sensor(const std::vector<std::filesystem::path>& files,
                                            const std::vector<Time>& starts, const std::string& folder);

/// Row of every point of a scan. Throws InputError naming `source` if the scan has other rings.
[[nodiscard]] std::vector<std::int32_t> lasers_by_rings(const PcdPoints& points, const PcdSensor& sensor,
                                                        const std::string& source);

}  // namespace mapless
