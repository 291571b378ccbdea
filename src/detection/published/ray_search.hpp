#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// The measured ray of a scan cell that passes nearest to a point.
struct NearestRay {
  int laser = -1;  ///< -1: no ray
  int column = -1;
  double distance_m = std::numeric_limits<double>::infinity();  ///< of the point from the ray's line
  double range_m = 0;  ///< of the point's foot along the ray, from the ray's own origin
  [[nodiscard]] bool found() const { return laser >= 0; }
};

/// Finds the measured ray of one scan that passes nearest to a point: over lasers l and time t it minimises
/// ||e_l(t)||, e_l(t) = D T_lh T_hv(t) T_v0(t) [q; 1] (paper Eq. 1 and 2), then takes the measured ray
/// closest in time. Each ray has its laser's own pose and its own instant, and goes forward only. Where the
/// recording has no firing (ReturnCode::absent), the nearest column of that laser that has one is taken, up
/// to kColumnReach away: recordings drop single firings and packets' ends. Oracle:
/// tests/oracle/ray_search_oracle.hpp, brute force over all rays.
class RaySearch {
 public:
  static constexpr int kColumnReach = 4;

  /// Keeps a reference to `scan`.
  explicit RaySearch(const CompensatedScan& scan);

  /// `q_0`: a point in the world frame [m]. None if no ray passes within `limit_m` of it; a limit saves the
  /// search for points that the scan does not observe.
  [[nodiscard]] NearestRay nearest(const Eigen::Vector3d& q_0,
                                   double limit_m = std::numeric_limits<double>::infinity()) const;

  /// An upper bound of the range of q_0 from any of the rays' origins.
  [[nodiscard]] double longest_range(const Eigen::Vector3d& q_0) const;

 private:
  // A point in the frame of one laser at the instant of one column: beam along x.
  struct Sighting {
    int at;  // the column
    Eigen::Vector3d q_h;
    Eigen::Vector3d q_l;
    double column;  // at which the beam would point at it, by the azimuth seen from this column
  };
  [[nodiscard]] Sighting sight(const Eigen::Vector3d& q_0, int laser, int column) const;
  [[nodiscard]] double column_of_direction(const Eigen::Vector3d& q_0) const;
  [[nodiscard]] int clamped_column(double column) const;
  [[nodiscard]] int laser_of_elevation(double elevation_rad) const;
  [[nodiscard]] NearestRay measured_ray(const Eigen::Vector3d& q_0, int laser, int column) const;
  [[nodiscard]] NearestRay measured_ray(const Sighting& s, int laser) const;
  // None where none can be nearer than `known`.
  [[nodiscard]] NearestRay nearest_of_laser(const Eigen::Vector3d& q_0, int laser, double hub_column,
                                            const NearestRay& known) const;
  [[nodiscard]] double least_distance(const Sighting& s, int laser) const;
  struct Cone {           // of a laser's beams about the hub's axis
    double cosine, sine;  // of the elevation
    double height_m;      // of the apex
    double beside_m;      // of the laser from the axis
  };
  // Betters `best` over all lasers that can, from the one that points nearest on to both sides.
  void descend(const Eigen::Vector3d& q_0, double hub_column, NearestRay& best) const;

  const CompensatedScan& scan_;
  double columns_per_rad_;                // with the sign of the spin
  std::vector<SE3> column_T_h0_;          // T_hv(t) T_v0(t) at each column's instant
  std::vector<Vector6d> column_varpi_h_;  // the sensor's velocity then, in the hub's frame
  std::vector<SE3> laser_T_lh_;
  std::vector<double> firing_s_;        // of each laser, after its column's instant
  std::vector<double> offset_columns_;  // of each laser's azimuth offset
  std::vector<Cone> cones_;             // of each laser
  double max_offset_columns_ = 0;       // its largest magnitude
  double max_offset_s_ = 0;             // the longest between hub and laser pointing the same way
  Eigen::Vector3d centre_h_ = Eigen::Vector3d::Zero();  // mean of the lasers' origins
  double origin_spread_m_ = 0;                          // how far any of them is from it
  double travel_m_ = 0;                                 // of the sensor in the scan
  double turn_rad_ = 0;                                 // the same
};

}  // namespace mapless
