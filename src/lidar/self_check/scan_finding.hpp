#pragma once

#include <numbers>
#include <string>

#include <mapless/lidar/self_check.hpp>

namespace mapless::inline v1 {

/// What one check found in one scan.
struct ScanFinding {
  Trust trust = Trust::unknown;
  double size = 0;  ///< what is measured: the scans are compared by it
  std::string measured;
  std::string problem;
  std::string remedy;
};

inline constexpr double kDegree = std::numbers::pi / 180;  ///< [rad]
/// Points that a check is made of: fewer than 100 show nothing, more than 2000 do not change a median.
inline constexpr std::size_t kFewestSamples = 100, kMostSamples = 2000;

}  // namespace mapless
