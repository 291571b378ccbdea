#include "odometry/registration/time_bins.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include <Eigen/Geometry>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mapless::inline v1 {
namespace {

// Bins per scan. At 10 Hz a bin is 3.1 ms, so that half of one, moved to first order, errs by less than 0.5
// mm at 200 deg/s and 30 m: (w t)^2 / 2 x range.
constexpr std::int64_t kBinsPerScan = 32;

// The point as it would have been measured at the middle of its bin, to first order.
Eigen::Vector3d at_middle(const TimeBins::Point& point, const Vector6d& varpi) {
  const Eigen::Vector3d step = varpi.head<3>() + varpi.tail<3>().cross(point.position_v);
  return point.position_v - point.dt * step;
}

}  // namespace

TimeBins::TimeBins(const std::vector<ScanPoint>& keypoints, Time scan_start, Time earliest) {
  const std::int64_t skip_ns = (earliest - scan_start).nanoseconds();
  const auto first = std::find_if(keypoints.begin(), keypoints.end(),
                                  [&](const ScanPoint& keypoint) { return keypoint.time_ns >= skip_ns; });
  if (first == keypoints.end()) return;
  const std::int64_t start_ns = first->time_ns;
  const std::int64_t width_ns = (keypoints.back().time_ns - start_ns) / kBinsPerScan + 1;
  for (auto keypoint = first; keypoint != keypoints.end(); ++keypoint) {
    const std::int64_t number = (keypoint->time_ns - start_ns) / width_ns;
    const std::int64_t middle_ns = start_ns + number * width_ns + width_ns / 2;
    const Time middle = scan_start + Duration::from_nanoseconds(middle_ns);
    if (bins_.empty() || bins_.back().time != middle)
      bins_.push_back({middle, points_.size(), points_.size()});
    points_.push_back(
        {keypoint->position_v.cast<double>(), static_cast<double>(keypoint->time_ns - middle_ns) * 1e-9});
    bins_.back().end = points_.size();
  }
}

TimeBins TimeBins::reversed() const {
  TimeBins out;
  const std::size_t size = points_.size();
  std::transform(points_.rbegin(), points_.rend(), std::back_inserter(out.points_), [](const Point& point) {
    return Point{point.position_v, -point.dt};
  });
  std::transform(bins_.rbegin(), bins_.rend(), std::back_inserter(out.bins_), [&](const Bin& bin) {
    return Bin{Time::from_nanoseconds(-bin.time.nanoseconds()), size - bin.end, size - bin.begin};
  });
  return out;
}

TimeBins TimeBins::before(Time end) const {
  TimeBins out;
  std::copy_if(bins_.begin(), bins_.end(), std::back_inserter(out.bins_),
               [&](const Bin& bin) { return bin.time < end; });
  const std::size_t size = out.bins_.empty() ? 0 : out.bins_.back().end;
  out.points_.assign(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(size));
  return out;
}

PointResidual point_residual(const Eigen::Vector3d& p_v, const SE3& T_v0, const MapPlane& plane,
                             const PointWeights& weights) {
  const Eigen::Vector3d normal_v = T_v0.rotation() * plane.normal_0;
  PointResidual out;
  out.error_m = normal_v.dot(p_v - T_v0 * plane.point_0);
  if (!(std::abs(out.error_m) <= weights.gate_m)) return out;
  out.a << normal_v, p_v.cross(normal_v);
  const double scale = weights.robust_sigmas * weights.robust_sigmas;
  out.robust_weight = plane.variance / (plane.variance + out.error_m * out.error_m / scale);
  out.weight = out.robust_weight / plane.variance;
  out.normal_noise = out.weight * plane.normal_variance;
  return out;
}

void BinSums::add(const PointResidual& residual) {
  if (residual.weight == 0) return;
  const Vector6d weighted = residual.weight * residual.a;
  information += weighted * residual.a.transpose();
  gradient -= weighted * residual.error_m;
  weight += residual.weight;
  soft_inliers += residual.robust_weight;
  normal_noise += residual.normal_noise;
  ++inliers;
}

std::vector<BinSums> sum_residuals(const TimeBins& bins, const KnotInterval& interval, const PlaneSource& map,
                                   const PointWeights& weights, std::vector<CachedPlane>& planes) {
  planes.resize(bins.points().size());
  std::vector<BinSums> sums(bins.bins().size());
  std::vector<Eigen::Vector3d> points_v(bins.points().size()), points_0(bins.points().size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums.size(), 1), [&](const auto& range) {
    for (std::size_t b = range.begin(); b < range.end(); ++b) {
      const TimeBins::Bin& bin = bins.bins()[b];
      const KnotInterval::State at = interval.at(bin.time);
      sums[b].T_v0 = at.state.T_v0;
      sums[b].pose_jacobian = at.pose_jacobian;
      const SE3 T_0v = at.state.T_v0.inverse();
      for (std::size_t i = bin.begin; i < bin.end; ++i) {
        points_v[i] = at_middle(bins.points()[i], at.state.varpi);
        points_0[i] = T_0v * points_v[i];
      }
      const std::size_t count = bin.end - bin.begin;
      map.find_planes(std::span(points_0).subspan(bin.begin, count),
                      std::span(planes).subspan(bin.begin, count));
      for (std::size_t i = bin.begin; i < bin.end; ++i) {
        const auto& plane = planes[i].plane;
        if (plane) sums[b].add(point_residual(points_v[i], at.state.T_v0, *plane, weights));
      }
    }
  });
  return sums;
}

void add_points(const std::vector<BinSums>& sums, std::size_t k, double information_ratio,
                WindowSystem& system) {
  using Matrix6x12d = Eigen::Matrix<double, 6, 12>;
  for (const BinSums& bin : sums) {
    if (bin.inliers == 0) continue;
    const Matrix6x12d to_first = bin.pose_jacobian.leftCols<12>();
    const Matrix6x12d to_second = bin.pose_jacobian.rightCols<12>();
    const Matrix6d information = information_ratio * bin.information;
    const Vector6d gradient = information_ratio * bin.gradient;
    const Matrix6x12d first = information.lazyProduct(to_first);
    const Matrix6x12d second = information.lazyProduct(to_second);
    system.diagonal[k] += to_first.transpose().lazyProduct(first);
    system.above[k] += to_first.transpose().lazyProduct(second);
    system.diagonal[k + 1] += to_second.transpose().lazyProduct(second);
    system.gradient[k] += to_first.transpose() * gradient;
    system.gradient[k + 1] += to_second.transpose() * gradient;
  }
}

}  // namespace mapless
