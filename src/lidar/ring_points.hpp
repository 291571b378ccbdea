#pragma once

#include <vector>

namespace mapless::inline v1 {

/// Cylindrical coordinates of one point of a ring, and the scan it is from.
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

/// Robust line through every ring. Rings whose points cannot tell the origin (few, or all at one distance)
/// take it from their neighbours by interpolation, and rings with no points at all their elevation too.
[[nodiscard]] std::vector<RingLine> fit_ring_lines(const std::vector<RingPoints>& rings);

/// RMS height of the points over their lines; the furthest 5 % (mixed returns) do not count.
[[nodiscard]] double ring_line_residual(const std::vector<RingPoints>& rings,
                                        const std::vector<RingLine>& lines);

/// What the azimuths tell of one laser.
struct RingAzimuth {
  double offset_rad = 0;
  double across_m = 0;  ///< horizontal origin, to the left of the beam
  bool known = false;
};

struct AzimuthGrid {
  int encoder_steps = 0;  ///< 0: the azimuths show no grid
  int columns = 0;        ///< firings in a turn
  bool absolute = false;  ///< offsets are whole ones, centred on 0; otherwise modulo a column
  std::vector<RingAzimuth> rings;
};

/// Finds the grid of the azimuths and every ring's place on it. `sign` is the direction of the spin.
[[nodiscard]] AzimuthGrid find_azimuth_grid(const std::vector<RingPoints>& rings, double start_azimuth_rad,
                                            double sign);

}  // namespace mapless
