#pragma once

/// @file
/// Folder export: the clouds that `mapless export` writes. In go labelled scans (view/labelled_drive.hpp);
/// out come point clouds as PCD or PLY, one per scan or one map of a drive.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace mapless::app {

enum class CloudFormat { pcd, ply };

/// One whole number per point.
struct CloudColumn {
  std::string_view name;
  std::vector<std::uint32_t> values;
};

/// Points with further columns of the same length.
struct Cloud {
  std::vector<Eigen::Vector3d> points;  ///< [m]
  std::vector<CloudColumn> columns;
};

/// The bytes of a binary, little-endian file: PCD 0.7 (`DATA binary`) or PLY 1.0. Fields x, y, z, then the
/// columns as uint32. Coordinates are float32, and float64 if one of them is 8192 m or more from 0: from
/// there on the steps of float32 are 1 mm.
[[nodiscard]] std::string cloud_file(const Cloud& cloud, CloudFormat format);

}  // namespace mapless::app
