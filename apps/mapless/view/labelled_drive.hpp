#pragma once

/// @file
/// Folder view: a recording and a result of mapless detect, read together, as the page of `mapless view` and
/// the files of `mapless export` show them. In go a Dataset and a ResultFolder; out come motion-compensated,
/// labelled points, the bytes of the page, or clouds. Nothing here decides whether a point is dynamic.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::app {

/// One scan with its labels. All but `points` have one element per input record.
struct LabelledCloud {
  std::size_t number = 0;  ///< of the scan in the recording, from 0
  std::shared_ptr<const LidarScan> scan;
  SE3 T_0v;            ///< world from sensor at the start of the scan
  LocalPoints points;  ///< motion-compensated, one per return; world axes, relative to points.origin_0
  std::vector<std::uint32_t> labels;
  std::optional<std::vector<std::uint32_t>> truth;
  std::optional<std::vector<std::uint8_t>> stages;  ///< bit s: dynamic after stage s (detection.hpp)
  std::optional<std::vector<float>> probability;    ///< that the point moves; NaN: not known
};

/// The labelled scans of a recording. Without a result, the true labels of the recording are the labels.
/// Poses are those of the result, else of the recording, else the sensor is taken to stand.
class LabelledDrive {
 public:
  /// `dataset` outlives the drive. `result` empty: none. Throws InputError for a result that cannot be read,
  /// ParameterError if there is neither a result nor a true label.
  LabelledDrive(const Dataset& dataset, const std::filesystem::path& result);
  /// Labels of some scans, in place of a result, by number of the scan: one per input record.
  LabelledDrive(const Dataset& dataset, std::map<std::size_t, std::vector<std::uint32_t>> labels,
                const std::vector<ObjectRow>& objects);

  /// Numbers of the scans that have labels, increasing.
  [[nodiscard]] const std::vector<std::size_t>& scans() const { return scans_; }
  /// Throws InputError for files that do not fit the recording. Thread-safe.
  [[nodiscard]] LabelledCloud read(std::size_t scan) const;
  /// World from sensor at the start of a scan, without reading it.
  [[nodiscard]] SE3 start_pose(std::size_t scan) const;
  /// The objects of the result in one scan, by id; none without a result.
  [[nodiscard]] const std::vector<ObjectRow>& objects(std::size_t scan) const;
  [[nodiscard]] const Dataset& dataset() const { return dataset_; }
  [[nodiscard]] const std::optional<ResultFolder>& result() const { return result_; }
  /// False where neither the result nor the recording has poses.
  [[nodiscard]] bool has_poses() const { return has_poses_; }

 private:
  void place();  // by its trajectory

  const Dataset& dataset_;
  std::optional<ResultFolder> result_;
  std::map<std::size_t, std::vector<std::uint32_t>> given_;  // labels
  std::vector<std::size_t> scans_;
  std::shared_ptr<const Trajectory> trajectory_;
  bool has_poses_ = true;
  std::map<std::size_t, std::vector<ObjectRow>> objects_;
};

}  // namespace mapless::app
