#pragma once

#include <vector>

#include "odometry/keypoints/keypoints.hpp"
#include "odometry/map/plane_search.hpp"
#include "odometry/solver/knot_interval.hpp"
#include "odometry/solver/window_solver.hpp"

namespace mapless::inline v1 {

/// Weights of the point-to-plane residuals.
struct PointWeights {
  double gate_m;         ///< a point farther from its plane is an outlier, of weight 0
  double robust_sigmas;  ///< scale of the Cauchy loss, in standard deviations of the distance
};

/// The keypoints of a scan in bins of equal duration, by increasing time. A bin is short enough for the
/// motion within it to be linear to first order (method.md section 6).
class TimeBins {
 public:
  /// `keypoints` by increasing time. Those before `earliest` are dropped.
  TimeBins(const std::vector<ScanPoint>& keypoints, Time scan_start, Time earliest);
  TimeBins() = default;

  struct Bin {
    Time time;          ///< the middle of the bin
    std::size_t begin;  ///< its points are [begin, end) of points()
    std::size_t end;
  };
  struct Point {
    Eigen::Vector3d position_v;  ///< sensor frame at the point's own instant [m]
    double dt;                   ///< time since the middle of its bin [s]
  };
  /// The same points with time reversed: t becomes -t.
  [[nodiscard]] TimeBins reversed() const;
  /// The bins whose middle is before `end`.
  [[nodiscard]] TimeBins before(Time end) const;

  [[nodiscard]] const std::vector<Bin>& bins() const { return bins_; }
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }

 private:
  std::vector<Bin> bins_;
  std::vector<Point> points_;
};

/// The linearised residual of one point: e = error_m - a . d, where d is the left perturbation of the pose of
/// its bin.
struct PointResidual {
  Vector6d a = Vector6d::Zero();
  double error_m = 0;        ///< signed distance from the plane
  double weight = 0;         ///< robust_weight / variance of the distance [1/m^2]; 0 for an outlier
  double robust_weight = 0;  ///< of the Cauchy loss: 1 on the plane, towards 0 far from it
  double normal_noise = 0;   ///< weight x variance of the tilt of the normal
};

/// The residual of `p_v`, measured at the instant of `T_v0`.
[[nodiscard]] PointResidual point_residual(const Eigen::Vector3d& p_v, const SE3& T_v0, const MapPlane& plane,
                                           const PointWeights& weights);

/// Sums over the inliers of one bin.
struct BinSums {
  SE3 T_v0;  ///< at the middle of the bin
  Matrix6x24d pose_jacobian;
  Matrix6d information = Matrix6d::Zero();  ///< sum of weight a a^T
  Vector6d gradient = Vector6d::Zero();     ///< sum of -weight a error_m
  double weight = 0;
  double soft_inliers = 0;  ///< sum of robust weights, 0 to `inliers`
  double normal_noise = 0;
  int inliers = 0;  ///< points within the gate of a plane

  void add(const PointResidual& residual);
};

/// Associates every point with a plane of the map and sums the residuals bin by bin, in the order of the
/// points, so that the result does not depend on the number of threads. `planes` caches the association from
/// one iteration to the next; pass an empty vector at first, and whenever the map is another one.
[[nodiscard]] std::vector<BinSums> sum_residuals(const TimeBins& bins, const KnotInterval& interval,
                                                 const PlaneSource& map, const PointWeights& weights,
                                                 std::vector<CachedPlane>& planes);

/// Adds the sums of the bins between knots k and k + 1 to the normal equations, times `information_ratio`.
void add_points(const std::vector<BinSums>& sums, std::size_t k, double information_ratio,
                WindowSystem& system);

}  // namespace mapless
