#pragma once

#include <cstddef>

#include "view/labelled_drive.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::app {

enum class ExportedClass { is_static, moving, all };

/// Points of one scan that are exported, and how many of it have which label.
struct ExportedPoints {
  ExportCloud cloud;
  std::size_t is_static = 0, moving = 0, unknown = 0;
};

/// Points of a class, motion-compensated, in the order of LidarScan::returns; `all` has the columns `label`
/// (0 unknown, 9 static, 251 dynamic), `object` (its number, 0 none) and `record` (of the point in the
/// input), and where the result has it `probability` (float32; NaN: not known). In the world's axes, or in
/// those of the sensor at the start of the scan.
[[nodiscard]] ExportedPoints exported_points(const LabelledCloud& scan, ExportedClass wanted,
                                             bool in_sensor_frame);

}  // namespace mapless::app
