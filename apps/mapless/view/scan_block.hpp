#pragma once

#include <cstddef>
#include <string>

#include <Eigen/Core>

#include "view/labelled_drive.hpp"

namespace mapless::app {

/// What the page's header says of one scan beside its block.
struct ScanBlock {
  std::string bytes;                                      ///< as encode_scan says
  std::size_t points = 0;                                 ///< number of returns
  double step_m = 0;                                      ///< of the coordinates [m]
  std::size_t dynamic = 0;                                ///< points labelled dynamic
  std::size_t hits = 0, false_positives = 0, missed = 0;  ///< by the true labels, where there are any
};

/// The planes that only some results have. All scans of a page have the same.
struct OptionalPlanes {
  bool stages = false, probability = false;
};

/// Coordinates are whole multiples of this; a scan that reaches beyond 163 m gets a coarser step.
inline constexpr double kCoordinateStep_m = 0.005;

/// The returns of a scan as the page reads them (viewer/src/drive.ts has the other end), in the order of
/// LidarScan::returns. Number of returns of each laser (uint32), then one plane after another:
///
///     x, y, z     int16 in steps of step_m, along the axes of the page, from the sensor's place at the start
///     column      uint16
///     record      uint32, number of the point in the input
///     class       uint8: low 2 bits the label, next 2 bits the truth; 0 unknown, 1 static, 2 dynamic, 3 none
///     object      uint16, number of the object
///     stages      uint8, only where the result has stage files
///     probability uint8, only where the result has it: that the point moves, times 254; 255 not known
///
/// Numbers of more than one byte are differences to the number before, zigzag coded; all low bytes come
/// before all next bytes. `R_page_world` turns the world's axes into those of the page.
[[nodiscard]] ScanBlock encode_scan(const LabelledCloud& cloud, const Eigen::Matrix3d& R_page_world,
                                    const OptionalPlanes& planes);

/// As the page in a file has blocks. Throws Error if zlib runs out of memory.
[[nodiscard]] std::string compress_zlib(const std::string& bytes);

}  // namespace mapless::app
