#pragma once

/// @file
/// Folder export: the clouds that `mapless export` writes. In go labelled scans (view/labelled_drive.hpp);
/// out come point clouds as PCD, PLY or LAS, one per scan or one map of a drive.

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace mapless::app {

/// One whole number per point, or one float32, whose bits the values are.
struct CloudColumn {
  std::string_view name;
  std::vector<std::uint32_t> values;
  bool is_float = false;
};

/// Points with further columns of the same length.
struct Cloud {
  std::vector<Eigen::Vector3d> points;  ///< [m]
  std::vector<CloudColumn> columns;
};

}  // namespace mapless::app
