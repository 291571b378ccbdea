#pragma once

#include <tuple>

#include <mapless/core/parameters.hpp>

namespace mapless::inline v1 {

/// The parameters of LidarOdometry. Sources are sections of docs/method.md.
struct OdometryParameters {
  int max_scan_points = 16000;
  double keypoint_voxel_m = 1.5;
  int min_keypoints = 1500;
  double min_range_m = 1.0;
  double map_radius_m = 100.0;
  double gate_m = 0.5;
  double robust_sigmas = 2.5;
  double residual_sigma_m = 0.02;
  double acceleration_density_translation = 0.03;
  double acceleration_density_rotation = 0.01;
  int max_iterations = 15;
  double min_inlier_ratio = 0.2;
  double min_constraint_ratio = 0.0001;
  double velocity_sigma_mps = 0.5;
  double speed_sigma_mps = 0.2;
  double angular_velocity_sigma_radps = 0.05;

  static constexpr auto declarations() {
    using P = OdometryParameters;
    return std::tuple{
        declare(&P::max_scan_points, "max_scan_points", "points", 500, 1000000,
                "a scan with more returns is thinned to about this many, near surfaces most", "method.md 6"),
        declare(
            &P::keypoint_voxel_m, "keypoint_voxel_m", "m", 0.1, 10.0,
            "side of the cubes of which each contributes one keypoint to the registration; halved if these "
            "are fewer than min_keypoints",
            "method.md 6"),
        declare(
            &P::min_keypoints, "min_keypoints", "points", 50, 100000,
            "fewest keypoints: the cubes are halved up to twice to have as many; three times as many if some "
            "direction is weakly constrained",
            "method.md 6"),
        declare(&P::min_range_m, "min_range_m", "m", 0.0, 20.0,
                "nearer returns are of the vehicle itself and are not used", "method.md 6"),
        declare(&P::map_radius_m, "map_radius_m", "m", 10.0, 1000.0,
                "the map keeps points within this distance of the sensor; farther returns are not used",
                "method.md 3"),
        declare(&P::gate_m, "gate_m", "m", 0.01, 10.0,
                "a point farther than this from its plane is an outlier", "method.md 3"),
        declare(&P::robust_sigmas, "robust_sigmas", "", 0.1, 1000.0,
                "scale of the Cauchy loss, in standard deviations of a point's distance from its plane",
                "method.md 3"),
        declare(&P::residual_sigma_m, "residual_sigma_m", "m", 0.001, 10.0,
                "expected standard deviation of points from their plane: the noise of the ranges",
                "method.md 6"),
        declare(
            &P::acceleration_density_translation, "acceleration_density_translation", "m^2/s^3", 1e-6, 1e6,
            "expected power spectral density of the white noise on linear acceleration; upper bound within a "
            "scan, while that from scan to scan is estimated from the motion so far",
            "method.md 6"),
        declare(&P::acceleration_density_rotation, "acceleration_density_rotation", "rad^2/s^3", 1e-6, 1e6,
                "the same for angular acceleration", "method.md 6"),
        declare(&P::max_iterations, "max_iterations", "", 1, 100, "most Gauss-Newton steps per scan",
                "method.md 3"),
        declare(
            &P::min_inlier_ratio, "min_inlier_ratio", "", 0.0, 1.0,
            "a scan with a smaller ratio of inliers to keypoints is lost: its motion is extrapolated with "
            "the motion prior",
            "method.md 6"),
        declare(
            &P::min_constraint_ratio, "min_constraint_ratio", "", 0.0, 1.0,
            "a direction in which the mean of (plane normal . direction)^2 over the inliers is smaller is "
            "unconstrained: the motion prior alone estimates the motion along it",
            "method.md 6"),
        declare(&P::velocity_sigma_mps, "velocity_sigma_mps", "m/s", 1e-3, 100.0,
                "standard deviation of each component of a measured velocity that states none",
                "odometry.md"),
        declare(&P::speed_sigma_mps, "speed_sigma_mps", "m/s", 1e-3, 100.0,
                "standard deviation of a measured speed that states none: slip, and the lever arm in turns",
                "odometry.md"),
        declare(&P::angular_velocity_sigma_radps, "angular_velocity_sigma_radps", "rad/s", 1e-4, 10.0,
                "standard deviation of each component of a measured angular velocity that states none: its "
                "bias, which is not estimated",
                "odometry.md"),
    };
  }
};

}  // namespace mapless
