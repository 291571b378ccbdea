#pragma once

/// @file
/// Folder kitti: KITTI raw, KITTI odometry and SemanticKITTI, whose clouds have neither rings nor times. A
/// path goes in, a Dataset comes out.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// One scan of such a recording.
struct BareCloudScan {
  std::filesystem::path file;
  Time start;  ///< of the turn, when the hub passes the seam
  Time end;
  std::optional<Time> compensated_to;
  std::optional<std::filesystem::path> labels;
};

/// A recording of bare clouds as its reader describes it before any cloud is read.
struct BareCloudRecording {
  std::string format;
  std::filesystem::path folder;
  std::vector<BareCloudScan> scans;
  std::shared_ptr<const Trajectory> trajectory;  ///< null: none
  std::vector<std::string> notes;
};

/// A dataset of KITTI clouds of a sensor that rotates clockwise with its seam at the rear. The sensor is that
/// of `options`, else estimated from up to five scans, whose motion compensation is undone first if there is
/// a trajectory.
[[nodiscard]] std::unique_ptr<Dataset> make_bare_cloud_dataset(BareCloudRecording recording,
                                                               const DatasetOptions& options);

/// Assigns to every scan the label file of its number, from the folder `options.labels`, else from `own` if
/// that is a folder. Throws InputError if the folder of the options does not exist or has no such file.
void find_label_files(BareCloudRecording& recording, const std::vector<int>& numbers,
                      const std::filesystem::path& own, const DatasetOptions& options);

}  // namespace mapless
