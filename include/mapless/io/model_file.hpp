#pragma once

#include <filesystem>
#include <string>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Reads the native sensor.yaml (method.md section 4). Unknown keys are errors. Throws InputError naming
/// file, key and value.
[[nodiscard]] LidarModel read_sensor_yaml(const std::filesystem::path& file);
/// Writes one that reads back to the same model (to the last digit of a double).
void write_sensor_yaml(const std::filesystem::path& file, const LidarModel& model);

/// Reads a Velodyne calibration file (velodyne_driver, velodyne_decoder or nebula YAML): one entry per laser
/// with vert_correction, rot_correction, vert_offset_correction, horiz_offset_correction. Timing, columns and
/// ranges are those of the named model with as many lasers. Throws InputError.
[[nodiscard]] LidarModel read_velodyne_calibration(const std::filesystem::path& file);

/// A named model, or a file of either kind above.
[[nodiscard]] LidarModel model_from_name_or_file(const std::string& name_or_file);

}  // namespace mapless
