#pragma once

#include <vector>

#include "odometry/keypoints/keypoints.hpp"
#include "odometry/map/plane_map.hpp"
#include "odometry/solver/knot_interval.hpp"
#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// How distances of points from planes count.
struct PointWeights {
  double gate_m;         ///< farther points are not matched
  double robust_sigmas;  ///< scale of the Cauchy loss, in standard deviations of the distance
};

/// Keypoints of a scan, by time, in bins short enough for the motion inside one to be linear.
class TimeBins {
 public:
  /// `keypoints` by time; those before `earliest` are left out.
  TimeBins(const std::vector<ScanPoint>& keypoints, Time scan_start, Time earliest);

  struct Bin {
    Time time;          ///< its middle
    std::size_t begin;  ///< keypoints [begin, end)
    std::size_t end;
  };
  struct Point {
    Eigen::Vector3d position_v;
    double dt;  ///< after the middle of its bin [s]
  };
  [[nodiscard]] const std::vector<Bin>& bins() const { return bins_; }
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }

 private:
  std::vector<Bin> bins_;
  std::vector<Point> points_;
};

/// One matched point: residual e = e_0 - a . d, where d is the left perturbation of the pose of its bin.
struct PointResidual {
  Vector6d a = Vector6d::Zero();
  double error_m = 0;
  double weight = 0;     ///< information and robust loss together; 0: not matched
  double agreement = 0;  ///< share of the weight that the robust loss leaves, 0 to 1
  double spurious = 0;   ///< weight x variance of the tilt of the normal
};

/// Distance of `p_v`, measured at the instant of `T_v0`, from the plane.
[[nodiscard]] PointResidual point_residual(const Eigen::Vector3d& p_v, const SE3& T_v0, const MapPlane& plane,
                                           const PointWeights& weights);

/// Sums over the points of one bin: sum w a a^T, and the gradient -sum w a e_0.
struct BinSums {
  SE3 T_v0;
  Matrix6x24d pose_jacobian;
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double weight = 0;
  double agreement = 0;
  double spurious = 0;
  int matched = 0;

  void add(const PointResidual& residual);
};

/// Finds a plane for every point, in `planes` where that of the last time still holds (empty: there is none
/// yet), and sums their residuals, bin by bin in the order of points: the same bits for any number of
/// threads.
[[nodiscard]] std::vector<BinSums> sum_residuals(const TimeBins& bins, const KnotInterval& interval,
                                                 const PlaneMap& map, const PointWeights& weights,
                                                 std::vector<PlaneNear>& planes);

/// Adds the sums of the bins between knots k and k + 1, of whose information `share` is believed.
void add_points(const std::vector<BinSums>& sums, std::size_t k, double share, WindowSystem& system);

}  // namespace mapless
