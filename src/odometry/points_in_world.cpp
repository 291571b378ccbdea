#include "odometry/points_in_world.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mapless {
namespace {

// So many that half of one, moved through to first order, errs by less than 0.1 mm at 200 deg/s and 30 m.
constexpr std::int64_t kSteps = 256;

// A step that visits every index once, neighbours far apart: near the golden section, and prime to the size.
std::size_t stride_through(std::size_t size) {
  auto stride = static_cast<std::size_t>(0.618 * static_cast<double>(size)) + 1;
  while (std::gcd(stride, size) != 1) ++stride;
  return stride;
}

struct Step {
  SE3 T_0v;
  Vector6d varpi;
};

}  // namespace

std::vector<Eigen::Vector3d> points_in_world(const LidarScan& scan, const TrajectoryKnot& k1,
                                             const TrajectoryKnot& k2, const OdometryParameters& parameters) {
  std::int64_t length_ns = std::max<std::int64_t>(1, (scan.end() - scan.start).nanoseconds());
  for (const LidarReturn& r : scan.returns) length_ns = std::max<std::int64_t>(length_ns, r.time_ns);
  const std::int64_t width_ns = length_ns / kSteps + 1;
  std::vector<Step> steps(kSteps);
  for (std::int64_t s = 0; s < kSteps; ++s) {
    const Time t = scan.start + Duration::from_nanoseconds(s * width_ns + width_ns / 2);
    const TrajectoryState state = interpolate(k1, k2, t);
    steps[static_cast<std::size_t>(s)] = {state.T_v0.inverse(), state.varpi};
  }
  std::vector<Eigen::Vector3d> all(scan.returns.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, all.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const LidarReturn& r = scan.returns[i];
      const std::int64_t s = std::max(0, r.time_ns) / width_ns;
      const Step& step = steps[static_cast<std::size_t>(s)];
      const std::int64_t middle_ns = s * width_ns + width_ns / 2;
      const double dt = static_cast<double>(r.time_ns - middle_ns) * 1e-9;
      const Eigen::Vector3d p_v = r.position_v.cast<double>();
      all[i] = step.T_0v * (p_v - dt * (step.varpi.head<3>() + step.varpi.tail<3>().cross(p_v)));
    }
  });
  const std::size_t stride = stride_through(all.size());
  std::vector<Eigen::Vector3d> usable;
  usable.reserve(all.size());
  for (std::size_t n = 0, i = 0; n < all.size(); ++n, i = (i + stride) % all.size()) {
    const double range = scan.returns[i].position_v.cast<double>().norm();
    if (range >= parameters.min_range_m && range <= parameters.map_radius_m) usable.push_back(all[i]);
  }
  return usable;
}

}  // namespace mapless
