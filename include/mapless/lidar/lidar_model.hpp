#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// One laser of a spinning lidar, as it sits in the rotating hub (frame h: z along the spin axis, x where the
/// hub's zero points).
struct Laser {
  double elevation_rad = 0;  ///< above the hub's x-y plane
  double azimuth_offset_rad =
      0;  ///< counter-clockwise positive; holds the hub's turn during firing_offset too
  Eigen::Vector3d origin_h_m = Eigen::Vector3d::Zero();
  Duration firing_offset;  ///< after the instant of its column

  /// Unit vector of the beam in the hub.
  [[nodiscard]] Eigen::Vector3d direction_h() const;
  /// Hub to laser frame: x along the beam, y horizontal, origin where the beam starts (T_lh of paper Eq. 1).
  [[nodiscard]] SE3 T_lh() const;
};

/// Which way the hub turns, seen from +z.
enum class SpinDirection { clockwise = -1, counter_clockwise = +1 };

/// Geometry and timing of a spinning lidar: every laser with its own pose, lasers by increasing elevation.
struct LidarModel {
  std::string name;
  double rotation_rate_hz = 10;
  SpinDirection direction = SpinDirection::clockwise;
  int columns = 0;  ///< firings in one turn
  double start_azimuth_rad = 0;
  double min_range_m = 0;
  double max_range_m = 0;
  std::vector<Laser> lasers;

  /// +1 counter-clockwise, -1 clockwise.
  [[nodiscard]] double sign() const { return static_cast<double>(direction); }
  /// Angle of the hub about +z at a (fractional) column: start_azimuth + direction 2 pi column / columns.
  [[nodiscard]] double hub_angle(double column) const;
  /// Where a return of `laser` lies in the sensor frame at the instant of firing:
  /// Rz(hub_angle) (origin + range (cos el cos az, cos el sin az, sin el)).
  [[nodiscard]] Eigen::Vector3d point_v(int laser, double column, double range_m) const;
  /// Step in elevation from a laser to the farther of its neighbours [rad]; 0 for a single laser.
  [[nodiscard]] double elevation_step(int laser) const;
  /// Largest step in elevation between neighbouring lasers [rad]; 0 for a single laser.
  [[nodiscard]] double largest_elevation_step() const;
};

/// Throws InputError naming `source` where a model cannot be one: no lasers, lasers not by increasing
/// elevation, values not finite, columns or rates not positive, min_range >= max_range, or beyond what any
/// sensor has (columns 1e6, rates 0.001 to 10000 Hz, ranges 1e6 m, origins 100 m).
void validate(const LidarModel& model, const std::string& source);

/// Models by name: HDL-64E-S2, HDL-64E-S3, VLP-16, HDL-32E, OS1-64, OS1-128, Pandar64, XT-32
/// (case-insensitive). Throws ParameterError listing the names for any other.
[[nodiscard]] LidarModel named_model(std::string_view name);
[[nodiscard]] const std::vector<std::string>& named_models();

/// How well the lasers of a model were estimated from clouds without rings (`mapless info` prints it).
struct ModelEstimate {
  int scans_used = 0;
  double elevation_residual_m =
      0;  ///< RMS height of the points over their laser's fitted cone (central 95 %)
  double azimuth_residual_columns = 0;  ///< RMS distance of the points from their column's centre, in columns
  int lasers_borrowed = 0;  ///< lasers whose vertical origin (or all) is interpolated from their neighbours
  int encoder_steps = 0;    ///< positions of the hub's encoder found in the azimuths; 0: none
  int azimuths_known = 0;   ///< lasers whose azimuth offset was found, else taken as 0
  /// The offsets are true ones, found from the sensor's irregular firing positions. Otherwise only the part
  /// of each that is less than a column is known: a uniform grid of columns looks the same turned by one.
  bool azimuths_absolute = false;
};

}  // namespace mapless
