#pragma once

#include <vector>

#include <Eigen/Core>

#include "detection/freespace/freespace_probe.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::test {

/// The answers of FreespaceProbe by the rules of freespace_probe.hpp, by brute force over all lasers and
/// firings, each ray from the pose of the sensor at the instant that laser fired, in double precision.
class FreespaceProbeOracle {
 public:
  /// `slopes`: of the surfaces of all points asked about.
  FreespaceProbeOracle(const LidarScan& reference, const Trajectory& trajectory,
                       const VotingParameters& parameters, const SurfaceSlopes& slopes = {});

  [[nodiscard]] FreespaceVerdict verdict(const Eigen::Vector3d& q_0) const {
    return verdict(q_0, 0, reference_.columns);
  }
  /// The same with the firings of columns [first, end) alone to choose from. Where a turning sensor
  /// observed a direction twice, at its start and its end, both answers are right.
  [[nodiscard]] FreespaceVerdict verdict(const Eigen::Vector3d& q_0, int first, int end) const;
  /// Whether a ray beside the windows ended at the range of q.
  [[nodiscard]] bool surface_beside(const Eigen::Vector3d& q_0) const;
  /// How near q is to a point of which `other` is the answer [m], tried in 26 directions and steps of a
  /// factor of two from 0.5 mm to 0.25 m; infinite where none is.
  [[nodiscard]] double margin_m(const Eigen::Vector3d& q_0, FreespaceVerdict other) const;
  /// Least angle between the direction of q and the hub's x axis at the scan's start and its end [rad].
  [[nodiscard]] double angle_from_seam(const Eigen::Vector3d& q_0) const;
  /// Where a ray starts and points, in the world.
  [[nodiscard]] const Eigen::Vector3d& origin_0(int laser, int column) const {
    return ray(laser, column).origin;
  }
  [[nodiscard]] const Eigen::Vector3d& direction_0(int laser, int column) const {
    return ray(laser, column).direction;
  }

 private:
  struct Ray {
    Eigen::Vector3d origin;
    Eigen::Vector3d direction;
    Eigen::Vector3d up;  // across the beam, away from the ground where the sensor is upright
    double range_m;      // how far it is known to have gone; NaN: not known
  };
  struct Sighting {
    int laser = -1;
    int column = -1;
    double range_m = 0;
    double height_m = 0;
    double left_m = 0;
  };
  [[nodiscard]] const Ray& ray(int laser, int column) const {
    return rays_[static_cast<std::size_t>(laser) * static_cast<std::size_t>(reference_.columns) +
                 static_cast<std::size_t>(column)];
  }
  [[nodiscard]] Sighting sight(const Eigen::Vector3d& q_0, int laser, int first, int end) const;
  // Of the lasers above and below q the firings that pass nearest.
  [[nodiscard]] std::vector<Sighting> around(const Eigen::Vector3d& q_0, int first, int end) const;
  [[nodiscard]] double spacing_rad(int laser) const;
  [[nodiscard]] double aside_rad(const Sighting& s, int column) const;
  [[nodiscard]] double tolerance_m(const Sighting& s) const;
  [[nodiscard]] bool in_window(const Sighting& s, int column, double width_deg) const;
  [[nodiscard]] FreespaceVerdict classify(const std::vector<Sighting>& around, const Sighting& nearest) const;
  [[nodiscard]] double hub_angle_to(const Eigen::Vector3d& q_0, int column) const;

  const LidarScan& reference_;
  const Trajectory& trajectory_;
  VotingParameters parameters_;
  SurfaceSlopes slopes_;
  std::vector<Ray> rays_;  // row-major
};

}  // namespace mapless::test
