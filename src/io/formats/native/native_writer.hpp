#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Writes a native sequence (method.md section 4). Every file is written beside and renamed; until finish()
/// the folder has no times.txt and is not a recording.
class NativeWriter {
 public:
  /// Makes `folder` and its sensor.yaml. Throws OutputError where the folder exists or cannot be made,
  /// InputError for a model that is not one.
  NativeWriter(std::filesystem::path folder, LidarModel model);

  /// Writes the next scan: a cell for every laser and column of the model, those no record names as faulty
  /// (unknown). `labels` and `intensities` (0 to 1, rounded to 255ths) are none, or one for each record;
  /// cells no record names get 0. Throws InputError where the start is not after that of the scan before, a
  /// record names no cell of the image or one that is taken, or labels or intensities are not as many as the
  /// records.
  void add_scan(Time start, const std::vector<LidarRecord>& records,
                const std::vector<std::uint32_t>& labels = {}, const std::vector<float>& intensities = {});

  /// Writes trajectory.txt (where there are poses) and then times.txt.
  void finish(const std::vector<TimedPose>& trajectory);

 private:
  std::filesystem::path folder_;
  LidarModel model_;
  std::vector<Time> starts_;
};

}  // namespace mapless
