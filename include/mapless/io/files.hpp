#pragma once

/// @file
/// Folder files of room io: whole files in and out, for what is not a recording (formats) and not a table
/// (tables). Paths go in, bytes, parameters and sensor models come out, or a typed error that names file,
/// line, key and value.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/core/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Writes `bytes` to a temporary file in the same folder and renames it to `file`: a reader sees the old file
/// or the complete new one, and so does whoever looks after a power cut: the content is synchronised to the
/// disk (fsync) before the rename and the folder after it, before this returns. A symbolic link is kept and
/// its target replaced. Throws OutputError with the reason of the system (TemporaryError where the disk is
/// full), and leaves nothing behind, if that fails or if `file` is not a regular file (a folder, a device).
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes);

/// In the names of these temporary files: ".NAME.partial-PROCESS-NUMBER". They have no name before they are
/// complete, but on file systems that cannot do so (O_TMPFILE): there, a killed process leaves one at most
/// for each of its threads.
inline constexpr std::string_view kPartialMark = ".partial-";

/// Appends `bytes` to an existing file and synchronises it to the disk (fsync). Throws OutputError with the
/// reason of the system, and leaves the file as it was, if that fails.
void append_to_file(const std::filesystem::path& file, std::string_view bytes);

/// A file that grows by whole rows. A run that goes on after an earlier one first verifies the rows of the
/// earlier run, then appends; what the file holds after the rows verified is replaced.
class GrowingFile {
 public:
  enum class Start {
    anew,    ///< replaces the file
    resumed  ///< keeps the file of an earlier run
  };
  /// `head`: what the file begins with. Throws OutputError, or InputError as verify does.
  GrowingFile(std::filesystem::path file, std::string_view head, Start start);

  /// Appends rows (append_to_file). Throws OutputError; the file then keeps its earlier rows.
  void append(std::string_view bytes);
  /// Throws InputError where the file does not hold these bytes next, after those appended or verified.
  void verify(std::string_view bytes);
  /// Removes the rows appended last. Throws OutputError.
  void undo_append();

 private:
  [[nodiscard]] bool holds_at(std::size_t offset, std::string_view bytes) const;

  std::filesystem::path file_;
  std::size_t size_ = 0, size_before_ = 0;  // [bytes], now and before the last append
};

/// Content of a file of at most 1 GiB, or of a pipe or device of at most 64 MiB. Throws InputError with the
/// reason: AccessError where the file is there and cannot be read.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& file);

enum class CloudFormat { pcd, ply, las };

/// The bytes of a binary, little-endian file: PCD 0.7 (`DATA binary`), PLY 1.0 or LAS 1.4. Fields x, y, z,
/// then the columns as uint32. Coordinates are float32, and float64 if one of them is 8192 m or more from 0:
/// from there on the steps of float32 are 1 mm. LAS: point format 6, whole steps of 0.1 mm from the first
/// point (coarser where they would not reach), columns as extra bytes; without points' intensity or colour.
[[nodiscard]] std::string cloud_file(const ExportCloud& cloud, CloudFormat format);
/// The format by the ending of the name. Throws ParameterError for another than .pcd, .ply and .las.
[[nodiscard]] CloudFormat cloud_format_of(const std::filesystem::path& file);
/// Writes `cloud` in the format of the name (write_file_atomically). Throws ParameterError, OutputError.
void write_cloud_file(const std::filesystem::path& file, const ExportCloud& cloud);

/// Sets parameters from a YAML file. A group of parameters is a map: "freespace.backward_threshold_m" is the
/// key backward_threshold_m in the map freespace. A parameter whose key is missing keeps its value. Throws
/// InputError for a file that cannot be read or is not YAML, ParameterError naming file, line and key for an
/// unknown or repeated key and a value of the wrong type or out of bounds.
void read_parameters_file(const std::filesystem::path& file,
                          const std::vector<ParameterReference>& parameters);

/// The content of such a file, with meaning, unit, bounds, default and source of each parameter as comments.
/// Reading it gives the same values. `defaults` has the same keys in the same order.
[[nodiscard]] std::string parameters_yaml(const std::vector<ParameterReference>& parameters,
                                          const std::vector<ParameterReference>& defaults);

/// Reads the sensor.yaml of a native recording (method.md section 4). Throws InputError naming file, key and
/// value for a file that cannot be read, an unknown key, and an invalid model (validate).
[[nodiscard]] LidarModel read_sensor_yaml(const std::filesystem::path& file);
/// Writes such a file; reading it gives the same model to the last digit of a double. Throws OutputError.
void write_sensor_yaml(const std::filesystem::path& file, const LidarModel& model);

/// Reads a Velodyne calibration file (YAML of velodyne_driver, velodyne_decoder or nebula): one entry per
/// laser with vert_correction, rot_correction, vert_offset_correction, horiz_offset_correction. Timing,
/// columns and ranges are those of the sensor with the same number of lasers; 32 lasers and a
/// distance_resolution of 0.004 are a VLP-32. Throws InputError.
[[nodiscard]] LidarModel read_velodyne_calibration(const std::filesystem::path& file);

/// The named model (named_model), or the model in a file: one of the formats above, the metadata of an Ouster
/// (JSON) or the angle correction of a Hesai (CSV). Throws InputError or
/// ParameterError.
[[nodiscard]] LidarModel model_from_name_or_file(const std::string& name_or_file);

/// The file that makes a folder the recording of a rig (docs/rigs.md): beside it lies
/// the recording of each sensor, in a folder of the sensor's name.
inline constexpr std::string_view kRigFile = "rig.yaml";
/// Whether the folder holds the recording of a rig.
[[nodiscard]] bool is_rig(const std::filesystem::path& folder);
/// The sensors in such a file, in its order. Throws InputError naming file, key and value: without a sensor,
/// for a name that is there twice or is no folder name, a quaternion whose norm is not 1 to 1e-3, a clock
/// offset of the first sensor that is not 0, and an unknown key.
[[nodiscard]] std::vector<RigSensor> read_rig_yaml(const std::filesystem::path& file);
/// Writes such a file; reading it gives the same sensors, to the rounding of a rotation. Throws OutputError.
void write_rig_yaml(const std::filesystem::path& file, const std::vector<RigSensor>& sensors);

}  // namespace mapless
