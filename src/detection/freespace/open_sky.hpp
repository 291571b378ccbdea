#pragma once

#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Which rays without a return met nothing within range, where the recording does not say why they have none:
/// drivers report the sky and a dark or glassy surface alike.
///
/// A ray met nothing if no ray within 7.5 degrees to the side and 2 up and down (the next lasers at least)
/// has a return; and so did those linked to it about which the same holds within 3 degrees and 1. The sky is
/// wide; panes and dark paint are seldom as wide, and some of their rays return. Some lower laser of the
/// column must have a return: below what returns, and in columns that are empty, the sensor may be covered,
/// or its packets lost. It may also be covered for good by what is nearer than the least range: so a ray
/// counts only where some ray of its laser within a degree has returned before, or if that laser has
/// returned in less than a quarter of the turn. A sensor on its head has no sky. Measured:
/// docs/notebook/detection.md, "Missing returns".
class OpenSky {
 public:
  /// Takes the next scan of one sensor. An element per cell; empty where the recording says why returns are
  /// missing: some cell, of this scan or one before, has ReturnCode::nothing.
  [[nodiscard]] std::vector<bool> of_next(const LidarScan& scan);

 private:
  bool told_ = false;  // why returns are missing
  // By laser and azimuth, in columns of the turn: whether a ray within a degree of it has returned, in this
  // scan or one before. Scans of point clouds begin anywhere, each with a model of its own.
  std::vector<std::vector<bool>> returned_once_;
};

}  // namespace mapless
