#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lidar/recovery/model_estimation.hpp"
#include "lidar/recovery/ring_recovery.hpp"
#include "lidar/scan_builder/raw_points.hpp"

namespace mapless::inline v1 {

/// Where the ring of a point comes from.
enum class RingSource {
  field,  ///< PointFields::ring
  rows,   ///< the rows of an organised cloud
  order,  ///< the order of the points: ring after ring, as KITTI stores them
};

/// A sensor estimated from its points.
struct RecoveredSensor {
  LidarModel model;
  BareCloudLayout layout;
  ModelEstimate estimate;
  RingSource rings_from = RingSource::order;
  std::size_t rows = 1;                    ///< of the clouds
  std::vector<std::int64_t> ring_numbers;  ///< of the points, in the order of layout.row_of_ring
  std::vector<std::string> notes;          ///< how it was found, one line each
};

/// Estimates the sensor from a few scans, at least one: rings by `field`, else `rows`, else `order`; spin
/// from the times of the points, else clockwise at the rate of `starts`, those of all scans of the recording.
/// Throws InputError naming `source` where the rings are not those of a spinning lidar.
[[nodiscard]] RecoveredSensor recover_sensor(std::vector<RawPoints> scans, std::span<const Time> starts,
                                             const std::string& source);

/// Row of every point of a scan. Throws InputError naming `source` where the scan has other rings.
[[nodiscard]] std::vector<std::int32_t> lasers_by_rings(const RawPoints& points,
                                                        const RecoveredSensor& sensor,
                                                        const std::string& source);

}  // namespace mapless
