#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Writes a native recording (method.md section 4). Every file is written atomically. Until finish() the
/// folder has no times.txt and is not a recording.
class NativeWriter {
 public:
  /// Creates `folder` and its sensor.yaml. Throws OutputError if the folder exists or cannot be created,
  /// InputError for an invalid model (validate).
  NativeWriter(std::filesystem::path folder, LidarModel model);

  /// Writes the next scan, with a cell for every laser and column of the model; cells without a record are
  /// faulty. `labels` and `intensities` (0 to 1, rounded to 1/255) are empty or have one entry per record;
  /// cells without a record get 0. Throws InputError if the start is not after that of the previous scan, if
  /// a record has no cell in the image or one that another record has, and if labels or intensities differ in
  /// number from the records.
  void add_scan(Time start, const std::vector<LidarRecord>& records,
                const std::vector<std::uint32_t>& labels = {}, const std::vector<float>& intensities = {});

  /// Writes trajectory.txt (if there are poses), then times.txt. Throws OutputError.
  void finish(const std::vector<TimedPose>& trajectory);

 private:
  std::filesystem::path folder_;
  LidarModel model_;
  std::vector<Time> starts_;
};

}  // namespace mapless
