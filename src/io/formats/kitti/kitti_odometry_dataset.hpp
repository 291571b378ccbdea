#pragma once

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// KITTI odometry and SemanticKITTI (Geiger et al., CVPR 2012; Behley et al., ICCV 2019), `sequences/NN/`:
/// `velodyne/NNNNNN.bin` (as KITTI raw's), `times.txt` (seconds since the first frame, a line per frame),
/// `calib.txt` (Tr: camera 0 from velodyne), poses of camera 0 at those instants in `poses.txt`
/// (SemanticKITTI's own) or
/// `../../poses/NN.txt`, `labels/NNNNNN.label` (SemanticKITTI). The clouds are already motion-compensated, to
/// the instant in times.txt, when the sensor faces forward: the middle of the turn. The turn is taken to last
/// the median difference of times.txt. Their HDL-64E is known to want its vertical angles turned by +0.205
/// degrees (Deschaud, ICRA 2018); that is not applied.
[[nodiscard]] bool looks_kitti_odometry(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Dataset> open_kitti_odometry(const std::filesystem::path& path,
                                                           const DatasetOptions& options);

}  // namespace mapless
