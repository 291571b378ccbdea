#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A recording: scans in time order, of one sensor.
class Dataset {
 public:
  virtual ~Dataset() = default;
  /// "native", "kitti-raw", "kitti", "mdlidar" or "pcd".
  [[nodiscard]] virtual std::string format() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual std::shared_ptr<const LidarModel> model() const = 0;
  /// Set where the model was estimated from the points.
  [[nodiscard]] virtual std::optional<ModelEstimate> model_estimate() const { return std::nullopt; }
  /// Start and end of scan k.
  [[nodiscard]] virtual Time scan_start(std::size_t k) const = 0;
  [[nodiscard]] virtual Time scan_end(std::size_t k) const = 0;
  /// The file scan k is read from, for messages.
  [[nodiscard]] virtual std::filesystem::path scan_file(std::size_t k) const = 0;
  /// Throws InputError naming the file for anything unusable. Thread-safe.
  [[nodiscard]] virtual LidarScan read(std::size_t k) const = 0;
  /// Truth of scan k, one label per input record (SemanticKITTI moving-object convention), where there is
  /// any. Throws InputError for a file of the wrong length.
  [[nodiscard]] virtual std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const = 0;
  /// The trajectory that comes with the recording; null where none does. Throws InputError.
  [[nodiscard]] virtual std::shared_ptr<const Trajectory> trajectory() const { return nullptr; }
  /// What of the recording's own is worth telling: where trajectory() and times come from, one line each.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

/// Meaning of the poses in a file: T_0v (world from sensor) or T_v0 (sensor from world).
enum class PoseDirection { world_from_sensor, sensor_from_world };

struct DatasetOptions {
  std::string format;  ///< empty: recognised from the folder's contents
  std::string sensor;  ///< a named model, or a calibration file; empty: the recording's own, else estimated
  std::filesystem::path labels;  ///< truth from this folder instead of the recording's own
  /// How an mdlidar recording's own poses are to be read; its documentation does not say.
  PoseDirection pose_direction = PoseDirection::world_from_sensor;
};

/// Throws InputError that names the first of the scans [first, first + count) that does not start after the
/// scan before it. The detector refuses such a scan too, but only once it reaches it, and cannot name the
/// file.
void require_time_order(const Dataset& dataset, std::size_t first, std::size_t count);

/// Opens a recording. Throws InputError naming the folder and what was looked for where no format, or more
/// than one, fits.
[[nodiscard]] std::unique_ptr<Dataset> open_dataset(const std::filesystem::path& path,
                                                    const DatasetOptions& options = {});

/// The formats open_dataset knows.
[[nodiscard]] const std::vector<std::string>& dataset_formats();

/// What reading a whole recording shows: how much there is, where its times and rings come from, and what is
/// odd.
struct RecordingSurvey {
  std::size_t scans = 0;
  std::size_t readable_scans = 0;
  Time begin;
  Time end;
  double median_period_s = 0;  ///< between the starts of scans; 0 for fewer than two

  Provenance time_source = Provenance::none;
  Provenance ring_source = Provenance::none;
  bool compensated = false;            ///< by somebody else, before it was recorded
  double compensated_to_fraction = 0;  ///< of the scan's length, for the first such scan

  std::size_t records = 0;  ///< of all scans, returns or not
  std::size_t returns = 0;
  std::size_t min_returns = 0, median_returns = 0, max_returns = 0;  ///< of a scan
  std::size_t faulty = 0;   ///< cells without a return, cause unknown (NaN points count here)
  std::size_t nothing = 0;  ///< cells with nothing within range
  std::size_t unusable =
      0;  ///< records that are neither a return nor a cell of the image: NaN points of bare clouds

  std::size_t labelled_scans = 0;
  std::size_t moving_points = 0, still_points = 0, unknown_points = 0;  ///< of the truth

  std::vector<std::string>
      oddities;  ///< one line each: what cannot be read, gaps, duplicates, order, size, NaN, points beyond
                 ///< the sensor's range or off its beams, times in another unit
};

/// Reads every scan and label once. A scan or label file that cannot be read is an oddity, not an error.
[[nodiscard]] RecordingSurvey survey_recording(
    const Dataset& dataset, const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace mapless
