#pragma once

#include <vector>

namespace mapless::inline v1 {

/// A firing position of the hub is one with the returns of at least this many lasers; a single one may be a
/// stray.
inline constexpr int kFiringLasers = 3;

/// Cylindrical coordinates of one point of a ring, and the number of its scan.
struct RingPoint {
  double azimuth_rad;
  double rho_m;
  double z_m;
  int scan;
};

/// The points of one laser over all scans used, scan by scan, in stored order.
using RingPoints = std::vector<RingPoint>;

/// The line z = origin_z_m + rho tan(elevation_rad) of a ring.
struct RingLine {
  double elevation_rad = 0;
  double origin_z_m = 0;
  bool borrowed = false;
};

/// Robust line through every ring. A ring whose points do not determine the origin (few, or all at one
/// distance) takes it from its neighbours by interpolation; a ring without points also its elevation.
[[nodiscard]] std::vector<RingLine> fit_ring_lines(const std::vector<RingPoints>& rings);

/// RMS distance [m] of the points from their lines, without the largest 5 % (mixed returns).
[[nodiscard]] double ring_line_residual(const std::vector<RingPoints>& rings,
                                        const std::vector<RingLine>& lines);

/// Azimuth offset and horizontal origin of one laser.
struct RingAzimuth {
  double offset_rad = 0;
  double across_m = 0;  ///< horizontal origin, to the left of the beam
  bool known = false;   ///< false: the azimuths of the ring show no phase
};

struct AzimuthGrid {
  int encoder_steps = 0;  ///< positions per turn; 0: the azimuths show no grid
  int columns = 0;        ///< firings in a turn
  bool absolute = false;  ///< offsets are complete and centred on 0; else known modulo a column
  std::vector<RingAzimuth> rings;
};

/// The widest spacing [rad] of which nearly all steps of azimuth between neighbours are multiples; 0: none.
[[nodiscard]] double find_grid_spacing(const std::vector<RingPoints>& rings);

/// Number of grid positions of the azimuths in a turn, near that spacing; 0: they are on no grid.
[[nodiscard]] int find_grid_positions(const std::vector<RingPoints>& rings, double spacing_rad,
                                      double start_azimuth_rad);

/// The azimuths of a ring are on a grid from this concentration on: a Gaussian spread of 0.16 of its spacing.
inline constexpr double kConcentrated = 0.6;

/// How well the azimuths of a ring lie on a grid of so many positions in a turn, under its best horizontal
/// origin: 1 for exactly, 1/sqrt(size) by chance.
[[nodiscard]] double grid_concentration(const RingPoints& ring, double start_azimuth_rad, int positions);

/// Estimates the grid of the azimuths and the phase of every ring on it. `sign`: LidarModel::sign().
[[nodiscard]] AzimuthGrid find_azimuth_grid(const std::vector<RingPoints>& rings, double start_azimuth_rad,
                                            double sign);

}  // namespace mapless
