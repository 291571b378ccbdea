#pragma once

#include <span>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

// The tables of the named models, one file per vendor.
[[nodiscard]] LidarModel hdl_64e_s2();
[[nodiscard]] LidarModel hdl_64e_s3();
[[nodiscard]] LidarModel vlp_16();
[[nodiscard]] LidarModel hdl_32e();
[[nodiscard]] LidarModel os1_64();
[[nodiscard]] LidarModel os1_128();
[[nodiscard]] LidarModel pandar_64();
[[nodiscard]] LidarModel xt_32();

/// One laser of a Velodyne calibration file, in the terms of that file.
struct VelodyneCorrection {
  double vert_rad = 0;        ///< elevation
  double rot_rad = 0;         ///< azimuth, counter-clockwise positive
  double vert_offset_m = 0;   ///< of the beam, upwards and at a right angle to it
  double horiz_offset_m = 0;  ///< of the beam, to its left
};

/// The laser whose hit at `range` from its origin is where Velodyne's own formula puts it (method.md section
/// 4, mdlidar).
[[nodiscard]] Laser velodyne_laser(const VelodyneCorrection& correction);

/// Timing, columns and ranges of the Velodyne sensor with as many lasers (16, 32, 64 or 128), with the firing
/// offsets of its lasers in the order of their ids and every other value of a laser 0. No lasers for any
/// other count. Of two sensors with 32 lasers, `distance_step_m` 0.004 is that of the VLP-32, else the
/// HDL-32E's.
[[nodiscard]] LidarModel velodyne_timing(std::size_t laser_count, double distance_step_m = 0);

/// An Ouster sensor of 1024 columns in its "sensor" frame: the encoder's zero is at the rear, the lidar frame
/// sits `height_m` up, and a beam starts `beam_origin_m` from the axis in the direction of the encoder. All
/// lasers of a column fire at once. Azimuths clockwise positive.
[[nodiscard]] LidarModel ouster_model(std::span<const double> altitude_deg,
                                      std::span<const double> azimuth_deg, double beam_origin_m,
                                      double height_m);

/// The spinning sensor of Hesai with such channels, at 10 Hz, azimuths clockwise positive. Firing times and
/// optical centre are those of Pandar64 and XT-32, for the others 0. No lasers where there is no such sensor.
[[nodiscard]] LidarModel hesai_model(std::span<const double> elevation_deg,
                                     std::span<const double> azimuth_deg);

/// Completes a model whose azimuths and origins hold for simultaneous firing of all lasers: rotates them by
/// the rotation of the hub during each firing offset at the model's rate, and sorts the lasers by increasing
/// elevation (stable).
[[nodiscard]] LidarModel assembled(LidarModel model);

[[nodiscard]] constexpr double radians(double degrees) { return degrees * (3.14159265358979323846 / 180); }

}  // namespace mapless
