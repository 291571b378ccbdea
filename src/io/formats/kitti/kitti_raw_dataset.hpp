#pragma once

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// KITTI raw (Geiger et al., IJRR 2013), `<date>/<date>_drive_NNNN_sync/velodyne_points/`:
/// `data/NNNNNNNNNN.bin` (float32 x, y, z [m], reflectance; Velodyne HDL-64E at about 10 Hz; hits only, no
/// ring, no time, not motion-compensated) and `timestamps.txt` (mid-scan), `timestamps_start.txt`,
/// `timestamps_end.txt`, line n for frame n, to the nanosecond. The sensor turns clockwise, its seam at the
/// rear. Some drives lack single frames: files are matched by their number.
///
/// `path` is the drive, its `velodyne_points`, or the date folder where it has one drive only.
[[nodiscard]] bool looks_kitti_raw(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Dataset> open_kitti_raw(const std::filesystem::path& path,
                                                      const DatasetOptions& options);

}  // namespace mapless
