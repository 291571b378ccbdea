#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/core/parameters.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Writes `bytes` to a file beside `file` and renames it over, so that a reader sees the old file or the
/// whole new one. A symbolic link is kept and its target replaced; what is no plain file (a folder, a device)
/// is refused. Throws OutputError (with the system's reason) and leaves nothing behind where that fails.
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes);

/// Appends to a file that is there. Throws OutputError (with the system's reason) and leaves the file as it
/// was where that fails.
void append_to_file(const std::filesystem::path& file, std::string_view bytes);

/// The whole file, at most 1 GiB; of a pipe or device at most 64 MiB. Throws InputError with the reason.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& file);

/// Sets parameters from a YAML file whose maps are the groups of the keys ("freespace.backward_threshold_m"
/// is backward_threshold_m in the map freespace). Keys the file does not have keep their value. Throws
/// InputError for a file that cannot be read or is not YAML, ParameterError naming file, line and key for an
/// unknown or repeated key, a value of the wrong type or out of bounds.
void read_parameters_file(const std::filesystem::path& file,
                          const std::vector<ParameterReference>& parameters);

/// The parameters as such a file, with meaning, unit, bounds, default and source of each as comments; reads
/// back to the same values. `defaults` has the same keys in the same order.
[[nodiscard]] std::string parameters_yaml(const std::vector<ParameterReference>& parameters,
                                          const std::vector<ParameterReference>& defaults);

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
