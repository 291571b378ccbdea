#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/io/trajectory_file.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/lidar/model_estimation.hpp>
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

}  // namespace mapless
