#pragma once

#include <filesystem>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// T_cam_velo: Tr of calib.txt of KITTI odometry, or R and T of calib_velo_to_cam.txt of KITTI raw, followed
/// by R_rect_00 of calib_cam_to_cam.txt in the same folder if present. Throws InputError.
[[nodiscard]] SE3 read_kitti_calibration(const std::filesystem::path& file);

}  // namespace mapless
