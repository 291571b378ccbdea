#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// One scan of a recording of bare clouds (KITTI).
struct BareCloudScan {
  std::filesystem::path file;
  Time start;  ///< of the turn, at the seam
  Time end;
  std::optional<Time> compensated_to;
  std::optional<std::filesystem::path> labels;
};

/// What a format's reader finds out of a recording of bare clouds before reading any.
struct BareCloudRecording {
  std::string format;
  std::filesystem::path folder;
  std::vector<BareCloudScan> scans;
  std::shared_ptr<const Trajectory> trajectory;  ///< may be null
  std::vector<std::string> notes;
};

/// A dataset of KITTI clouds of a sensor that turns clockwise with its seam at the rear. The sensor is the
/// one named by `options`, else estimated from up to five scans (with their compensation taken back where
/// there is a trajectory).
[[nodiscard]] std::unique_ptr<Dataset> make_bare_cloud_dataset(BareCloudRecording recording,
                                                               const DatasetOptions& options);

/// Gives every scan the label file of its number: from `options.labels`, else from `own` where that is a
/// folder. Throws InputError where the folder named by the options is absent or has none of them.
void find_label_files(BareCloudRecording& recording, const std::vector<int>& numbers,
                      const std::filesystem::path& own, const DatasetOptions& options);

}  // namespace mapless
