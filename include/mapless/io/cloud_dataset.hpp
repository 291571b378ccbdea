#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/lidar/point_fields.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

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
  /// Where times come from and the like, one line each, for the user.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

/// The recording of `source` as a Dataset. `sensor`: a named model or calibration file; empty: recovered from
/// eight scans spread over the recording (ScanBuilder::recover). The duration of a turn is the median period
/// of the scans, where that is the sensor's to 10 %. Throws what model_from_name_or_file,
/// ScanBuilder::recover and `source` throw.
[[nodiscard]] std::unique_ptr<Dataset> make_cloud_dataset(std::shared_ptr<const CloudSource> source,
                                                          const std::string& sensor);

}  // namespace mapless
