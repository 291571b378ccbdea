#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// One laser of a spinning lidar, as mounted in the rotating hub. Frame h of the hub: z along the spin axis,
/// x towards azimuth 0 of the hub.
struct Laser {
  double elevation_rad = 0;  ///< above the hub's x-y plane
  double azimuth_offset_rad =
      0;  ///< counter-clockwise positive; includes the rotation of the hub during firing_offset
  Eigen::Vector3d origin_h_m = Eigen::Vector3d::Zero();  ///< where the beam starts [m]
  Duration firing_offset;                                ///< firing time after the instant of the column

  /// Unit vector along the beam, in frame h.
  [[nodiscard]] Eigen::Vector3d direction_h() const;
  /// Laser frame l from hub frame: x along the beam, y horizontal, origin where the beam starts (T_lh of
  /// paper Eq. 1).
  [[nodiscard]] SE3 T_lh() const;
};

/// Direction of rotation of the hub, seen from +z.
enum class SpinDirection { clockwise = -1, counter_clockwise = +1 };

/// Geometry and timing of a spinning lidar: every laser has its own pose; lasers are sorted by increasing
/// elevation. The members are set freely and checked by validate(); every function that takes a scan or a
/// model from outside calls it. Member functions with a laser expect an index in [0, lasers.size()).
struct LidarModel {
  std::string name;
  double rotation_rate_hz = 10;
  SpinDirection direction = SpinDirection::clockwise;
  int columns = 0;               ///< firings of each laser in one turn
  double start_azimuth_rad = 0;  ///< hub angle at column 0
  double min_range_m = 0;        ///< nearer surfaces give no valid return
  double max_range_m = 0;        ///< farther surfaces give no return
  std::vector<Laser> lasers;

  /// +1 counter-clockwise, -1 clockwise.
  [[nodiscard]] double sign() const { return static_cast<double>(direction); }
  /// Angle of the hub about +z at a (fractional) column: start_azimuth + direction 2 pi column / columns.
  [[nodiscard]] double hub_angle(double column) const;
  /// Position [m] of a return of `laser` in the sensor frame v at the instant of firing:
  /// Rz(hub_angle) (origin + range (cos el cos az, cos el sin az, sin el)).
  [[nodiscard]] Eigen::Vector3d point_v(int laser, double column, double range_m) const;
  /// Difference in elevation [rad] between a laser and the farther of its two neighbours; 0 for a single
  /// laser.
  [[nodiscard]] double elevation_step(int laser) const;
  /// Largest difference in elevation [rad] between neighbouring lasers; 0 for a single laser.
  [[nodiscard]] double largest_elevation_step() const;
  /// The mean of these [rad]; 0 for a single laser.
  [[nodiscard]] double mean_elevation_step() const;
};

/// Throws InputError that names `source`, the member, its value and its bound for an invalid model: no
/// lasers, lasers not by increasing elevation, values not finite, columns not in [1, 1e6], more than 1e8
/// columns x lasers, rotation rate not in [0.001, 10000] Hz, maximum range not in (0, 1e6] m, minimum range
/// not in [0, maximum range), start azimuth or azimuth offsets beyond 720 degrees, laser origins beyond 10 m,
/// firing offsets longer than a turn.
void validate(const LidarModel& model, const std::string& source);

/// The model of a sensor by its name: HDL-64E-S2, HDL-64E-S3, VLP-16, HDL-32E, OS1-64, OS1-128, Pandar64,
/// XT-32 (case-insensitive). Throws ParameterError listing the names for any other.
[[nodiscard]] LidarModel named_model(std::string_view name);
[[nodiscard]] const std::vector<std::string>& named_models();

/// How well the lasers of a model were estimated from clouds without rings (`mapless info` prints it).
struct ModelEstimate {
  int scans_used = 0;
  double elevation_residual_m =
      0;  ///< RMS distance of the points from the fitted cone of their laser (central 95 %)
  double azimuth_residual_columns = 0;  ///< RMS distance of the points from the centre of their column
  int lasers_borrowed = 0;  ///< lasers whose vertical origin, or whole line, is interpolated from neighbours
  int encoder_steps = 0;    ///< positions of the angle encoder per turn found in the azimuths; 0: none
  int azimuths_known = 0;   ///< lasers with an estimated azimuth offset; the others have 0
  /// True if the azimuth offsets are complete, from the irregular firing positions of the sensor. Otherwise
  /// each is known modulo a column only: a uniform grid of columns looks the same when rotated by one column.
  bool azimuths_absolute = false;
};

}  // namespace mapless
