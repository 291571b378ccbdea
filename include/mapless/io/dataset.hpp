#pragma once

/// @file
/// Room io: recordings, results and their files. In go paths; out come a Dataset, labels, tables and
/// trajectories, or typed errors that name file, field, value and bound. The root of the room serves
/// recordings of any format; formats/ has one folder per format, which nothing but open_dataset includes;
/// tables/ has labels, objects and trajectories; files/ has whole files (bytes, text, YAML). Includes point
/// from the root to formats to tables to files.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/lidar/self_check.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A recording: the scans of one sensor in order of time. Every function with a scan number k throws
/// ParameterError for k >= size().
class Dataset {
 public:
  virtual ~Dataset() = default;
  /// "native", "kitti-raw", "kitti", "mdlidar" or "pcd".
  [[nodiscard]] virtual std::string format() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual std::shared_ptr<const LidarModel> model() const = 0;
  /// Set if the model was estimated from the points.
  [[nodiscard]] virtual std::optional<ModelEstimate> model_estimate() const { return std::nullopt; }
  /// Start and end of the turn of scan k.
  [[nodiscard]] virtual Time scan_start(std::size_t k) const = 0;
  [[nodiscard]] virtual Time scan_end(std::size_t k) const = 0;
  /// The file of scan k, for messages.
  [[nodiscard]] virtual std::filesystem::path scan_file(std::size_t k) const = 0;
  /// Reads scan k. Throws InputError naming the file for anything unusable. Thread-safe.
  [[nodiscard]] virtual LidarScan read(std::size_t k) const = 0;
  /// True labels of scan k, one per input record (io/labels.hpp), if the recording has any. Throws InputError
  /// for a file of the wrong length.
  [[nodiscard]] virtual std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const = 0;
  /// The trajectory of the recording itself; null if it has none. Throws InputError.
  [[nodiscard]] virtual std::shared_ptr<const Trajectory> trajectory() const { return nullptr; }
  /// What other sensors of the recording measured of the motion, for the odometry; in any order.
  [[nodiscard]] virtual std::vector<MotionMeasurement> measurements() const { return {}; }
  /// Where sensor model, times and trajectory() come from, one line each, for the user.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }

 protected:
  /// k; throws ParameterError unless there is a scan k.
  [[nodiscard]] std::size_t checked(std::size_t k) const;
};

/// Meaning of the poses in a file: T_0v (world from sensor) or T_v0 (sensor from world).
enum class PoseDirection { world_from_sensor, sensor_from_world };

/// Meaning of the two poses of a frame of an mdlidar recording. `end`: position_p is the pose at the start of
/// the frame, position that at its end. `start`: position is the pose at the start, position_p an earlier
/// one.
enum class FramePoseInstant { end, start };

/// Options of open_dataset.
struct DatasetOptions {
  std::string format;  ///< one of dataset_formats(); empty: recognised from the content of the folder
  std::string sensor;  ///< a named model or calibration file; empty: that of the recording, else estimated
  std::filesystem::path labels;  ///< read true labels from this folder instead of that of the recording
  /// Meaning of the poses in an mdlidar recording, which its documentation does not define. Default: the
  /// meaning under which static points move less between scans.
  std::optional<PoseDirection> pose_direction;
  std::optional<FramePoseInstant> pose_instant;
};

/// Throws InputError that names the first of the scans [first, first + count) that does not start after the
/// scan before it. The detector refuses such a scan too, but only once it reaches it, and cannot name the
/// file.
void require_time_order(const Dataset& dataset, std::size_t first, std::size_t count);

/// Opens the recording in the folder `path`. Throws InputError naming the folder and the files looked for if
/// no format or more than one fits, ParameterError for an unknown format or sensor.
[[nodiscard]] std::unique_ptr<Dataset> open_dataset(const std::filesystem::path& path,
                                                    const DatasetOptions& options = {});

/// Names of the formats whose files the folder `path` holds, found by their names alone; empty for a file. No
/// more than one: open_dataset(path) reads it without DatasetOptions::format.
[[nodiscard]] std::vector<std::string> recognised_formats(const std::filesystem::path& path);

/// Names of the formats that open_dataset reads.
[[nodiscard]] const std::vector<std::string>& dataset_formats();

/// One scan of a CloudSource.
struct Cloud {
  PointFields fields;
  std::shared_ptr<const void> owner;  ///< keeps the memory that `fields` refers to
  Time stamp;                         ///< ScanBuilder::build: what relative times of the points count from
  std::optional<Time>
      compensated_to;  ///< set if another system has already moved every point to this instant
};

/// A recording of clouds as a driver or a dataset has them: points with or without rings and times. Whoever
/// can read such a recording implements this; make_cloud_dataset does the rest. Functions with a scan number
/// k are called with k < starts().size(), and from several threads at once.
class CloudSource {
 public:
  virtual ~CloudSource() = default;
  /// A short name of the format, for messages: "pcd".
  [[nodiscard]] virtual std::string format() const = 0;
  /// The file or folder of the recording, for messages.
  [[nodiscard]] virtual std::filesystem::path path() const = 0;
  /// Start of every scan, increasing; at least one. The same object at every call.
  [[nodiscard]] virtual const std::vector<Time>& starts() const = 0;
  /// The file of scan k, or the name of its message, for messages.
  [[nodiscard]] virtual std::filesystem::path scan_file(std::size_t k) const = 0;
  /// Reads scan k. Throws InputError for anything unusable.
  [[nodiscard]] virtual Cloud read(std::size_t k) const = 0;
  /// Dataset::read_labels.
  [[nodiscard]] virtual std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const;
  /// Dataset::trajectory.
  [[nodiscard]] virtual std::shared_ptr<const Trajectory> trajectory() const { return nullptr; }
  /// Dataset::measurements.
  [[nodiscard]] virtual std::vector<MotionMeasurement> measurements() const { return {}; }
  /// Where times come from and the like, one line each, for the user.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

/// The recording of `source` as a Dataset. `sensor`: a named model or calibration file; empty: recovered from
/// eight scans spread over the recording (ScanBuilder::recover). The duration of a turn is the median period
/// of the scans, where that is the sensor's to 10 %. Throws what model_from_name_or_file,
/// ScanBuilder::recover and `source` throw.
[[nodiscard]] std::unique_ptr<Dataset> make_cloud_dataset(std::shared_ptr<const CloudSource> source,
                                                          const std::string& sensor);

/// Statistics of a whole recording: sizes, origin of times and rings, and irregularities.
struct RecordingSurvey {
  std::size_t scans = 0;
  std::size_t readable_scans = 0;
  Time begin;
  Time end;
  double median_period_s = 0;  ///< between the starts of two scans; 0 for fewer than two scans

  Provenance time_source = Provenance::none;
  Provenance ring_source = Provenance::none;
  bool compensated = false;  ///< motion-compensated by another system
  double compensated_to_fraction =
      0;  ///< instant of compensation in the first such scan: 0 its start, 1 its end

  std::size_t records = 0;  ///< of all scans, with or without a return
  std::size_t returns = 0;
  std::size_t min_returns = 0, median_returns = 0, max_returns = 0;  ///< per scan
  std::size_t faulty = 0;    ///< cells without a return for an unknown reason, NaN points included
  std::size_t nothing = 0;   ///< cells with nothing within range
  std::size_t unusable = 0;  ///< records that are neither a return nor a cell: NaN points of bare clouds

  std::size_t labelled_scans = 0;
  std::size_t moving_points = 0, still_points = 0, unknown_points = 0;  ///< by their true labels

  std::vector<std::string>
      oddities;  ///< irregularities, one line each: unreadable files, gaps, duplicates, order, sizes, NaN,
                 ///< points beyond the range of the sensor or off its beams, times in another unit
};

/// Reads every scan and label file once. A file that cannot be read is an irregularity, not an error.
/// `progress` (scans done, scans) may be empty.
[[nodiscard]] RecordingSurvey survey_recording(
    const Dataset& dataset, const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Holds a recording against what is said about it, on a few scans: points against the beams and columns of
/// the sensor, their ranges against its limits, times against the angle turned, and, where `given` is not
/// null, poses against the scans (docs/reliability.md, "The self-check"). Looks at scans spread over
/// [first, first + count). A scan that cannot be read is left out. Costs the reading of up to 100 scans.
[[nodiscard]] std::vector<CheckResult> check_recording(const Dataset& dataset,
                                                       const std::shared_ptr<const Trajectory>& given,
                                                       std::size_t first, std::size_t count);

/// Throws InputError for the first result that is wrong.
void require_trusted(const std::vector<CheckResult>& results);

}  // namespace mapless
