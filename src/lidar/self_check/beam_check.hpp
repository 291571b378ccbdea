#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar/self_check/scan_finding.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// T_v0(t). Throws TrajectoryDomainError where it is not known.
using GivenPoses = std::function<SE3(Time)>;

/// A laser is examined by itself from this many samples on: their median is then within the spread of one
/// point.
inline constexpr std::size_t kFewestOfLaser = 10;

/// A return, and the beam it is said to be on.
struct BeamSample {
  Eigen::Vector3d position_v;  ///< [m]
  int laser;
  int column;
  Time time;
};

/// Some returns of a scan, spread evenly over it, at least 2 m away: nearer ones are turned by small errors
/// of origins.
[[nodiscard]] std::vector<BeamSample> beam_samples(const LidarScan& scan);

/// How far off its beam a point may be. Elevation: half the usual distance between lasers, 0.2 to 1 degrees;
/// azimuth: two columns, at least 0.5 degrees.
struct BeamTolerance {
  double elevation_rad, azimuth_rad;
};
[[nodiscard]] BeamTolerance beam_tolerance(const LidarModel& model);

/// Of every sample, elevation and azimuth of the point less those of its beam [rad].
struct BeamErrors {
  std::vector<double> elevation, azimuth;

  /// Median over the samples of the larger of the two, in tolerances: right up to 1.
  [[nodiscard]] double misfit(const BeamTolerance& tolerance) const;
};
[[nodiscard]] BeamErrors beam_errors(const std::vector<BeamSample>& samples, const LidarModel& model);

/// The usual mistakes that bring the points onto the beams, in words, joined by "or"; empty where none does.
/// `given`: may be empty.
[[nodiscard]] std::string beam_mistakes(const std::vector<BeamSample>& samples, const LidarModel& model,
                                        const GivenPoses& given);

/// Points against beams and columns. Compensated scans are not checked: their points have left the beams.
[[nodiscard]] ScanFinding check_beams(const LidarScan& scan, const GivenPoses& given);

}  // namespace mapless
