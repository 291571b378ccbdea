#pragma once

#include <filesystem>

#include <mapless/core/se3.hpp>

namespace mapless::inline v1 {

/// Tr (camera from velodyne) of KITTI odometry's calib.txt, or R and T of KITTI raw's calib_velo_to_cam.txt
/// followed by R_rect_00 of calib_cam_to_cam.txt beside it where present. Throws InputError.
[[nodiscard]] SE3 read_kitti_calibration(const std::filesystem::path& file);

}  // namespace mapless
