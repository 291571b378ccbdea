#include "support/toy_scene.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mapless/io/labels.hpp>

namespace mapless::test {
namespace {

using Eigen::Vector3d;

constexpr double kDynamicSpeed_mps = 0.2;  // the paper's definition of truth [m/s]
constexpr Duration kForever = Duration::from_nanoseconds(std::int64_t{1} << 60);

std::uint64_t splitmix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// A standard normal number that depends on the ray alone, so that it does not depend on the order of
/// computation.
double normal_number(std::uint64_t seed, int scan, std::size_t record) {
  const std::uint64_t a = splitmix(splitmix(seed ^ splitmix(static_cast<std::uint64_t>(scan))) + record);
  const double u = (static_cast<double>(a >> 11) + 1) * 0x1p-53;
  const double v = static_cast<double>(splitmix(a) >> 11) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// Everything that is the same for all rays of one instant.
struct Instant {
  Time time;
  SE3 T_0v;
  std::vector<SE3> T_b0;

  Instant(const ToyScene& scene, Time t) : time(t), T_0v(scene.trajectory->at(t).T_v0.inverse()) {
    T_b0.reserve(scene.world.size());
    for (const ToyBody& body : scene.world) T_b0.push_back(body.pose_at(t).inverse());
  }
};

struct Cast {
  double range_m = 0;
  ReturnCode code = ReturnCode::faulty;
  std::uint32_t label = kLabelUnknown;
};

Cast cast_ray(const ToyScene& scene, int laser, int column, const Instant& now) {
  const Vector3d origin_0 = now.T_0v * scene.model->point_v(laser, column, 0);
  const Vector3d direction_0 = (now.T_0v * scene.model->point_v(laser, column, 1) - origin_0).normalized();
  const auto hit = first_hit(scene.world, now.T_b0, origin_0, direction_0);
  if (!hit || hit->range_m > scene.model->max_range_m) return {0, scene.empty_code, kLabelUnknown};
  if (hit->range_m < scene.model->min_range_m) return {};
  const ToyBody& body = scene.world[hit->body];
  const bool moves = body.speed_at(origin_0 + hit->range_m * direction_0, now.time) > kDynamicSpeed_mps;
  const std::uint32_t label =
      moves ? kLabelDynamic | static_cast<std::uint32_t>(body.object) << 16 : kLabelStatic;
  return {hit->range_m, ReturnCode::hit, label};
}

void cast_column(const ToyScene& scene, int number, const LidarScan& frame, int column, ToyScan& out) {
  const LidarModel& model = *scene.model;
  std::optional<Instant> now;
  for (int laser = 0; laser < frame.rows(); ++laser) {
    const Duration offset = model.lasers[static_cast<std::size_t>(laser)].firing_offset;
    const Time t = frame.column_time(column) + offset;
    if (!now || now->time != t) now.emplace(scene, t);
    const std::size_t i = static_cast<std::size_t>(laser) * static_cast<std::size_t>(frame.columns) +
                          static_cast<std::size_t>(column);
    const Cast cast = cast_ray(scene, laser, column, *now);
    const double noise =
        scene.range_noise_m > 0 ? scene.range_noise_m * normal_number(scene.seed, number, i) : 0;
    LidarRecord& record = out.records[i];
    record = {Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()), laser, column,
              static_cast<std::int32_t>((t - frame.start).nanoseconds()), cast.code};
    if (cast.code == ReturnCode::hit)
      record.position_v = model.point_v(laser, column, cast.range_m + noise).cast<float>();
    out.labels[i] = cast.label;
  }
}

}  // namespace

Time SteadyTrajectory::begin() const { return Time() - kForever; }
Time SteadyTrajectory::end() const { return Time() + kForever; }
TrajectoryState SteadyTrajectory::at(Time t) const {
  return {SE3::exp(t.seconds() * varpi_) * T_v0_, varpi_};
}

std::shared_ptr<const Trajectory> drive(double speed, double yaw_rate) {
  Vector6d varpi;
  varpi << -speed, 0, 0, 0, 0, -yaw_rate;
  return std::make_shared<SteadyTrajectory>(SE3(), varpi);
}

TrajectoryState MovedTrajectory::at(Time t) const {
  TrajectoryState state = trajectory_->at(t - delay_);
  state.T_v0 = state.T_v0 * T_0w_;
  return state;
}

ToyScan cast_scan(const ToyScene& scene, int number) {
  LidarScan frame;
  frame.model = scene.model;
  frame.columns = scene.model->columns;
  const double period_s = 1 / scene.model->rotation_rate_hz;
  frame.start = Time::from_seconds(number * period_s);
  frame.column_period = Duration::from_seconds(period_s / frame.columns);
  frame.time_source = frame.ring_source = Provenance::sensor;

  ToyScan out;
  const std::size_t size = scene.model->lasers.size() * static_cast<std::size_t>(frame.columns);
  out.records.resize(size);
  out.labels.resize(size);
  tbb::parallel_for(tbb::blocked_range<int>(0, frame.columns, 16), [&](const tbb::blocked_range<int>& range) {
    for (int column = range.begin(); column < range.end(); ++column)
      cast_column(scene, number, frame, column, out);
  });
  out.scan = std::make_shared<const LidarScan>(organise(frame, out.records, "toy scene"));
  return out;
}

}  // namespace mapless::test
