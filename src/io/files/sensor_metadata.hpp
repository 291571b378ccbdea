#pragma once

#include <filesystem>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Reads the metadata of an Ouster sensor (JSON, of any firmware): beam_altitude_angles, beam_azimuth_angles,
/// lidar_origin_to_beam_origin_mm, lidar_mode and the height in lidar_to_sensor_transform. Throws InputError.
[[nodiscard]] LidarModel read_ouster_metadata(const std::filesystem::path& file);

/// Reads the angle correction of a Hesai sensor (CSV with a header, then channel, elevation and azimuth [deg]
/// per row). The file has neither firing times nor the optical centre: those of Pandar64 and XT-32 are known,
/// the others are taken as 0. Columns are those at 10 Hz. Throws InputError, also for a solid-state sensor.
[[nodiscard]] LidarModel read_hesai_correction(const std::filesystem::path& file);

}  // namespace mapless
