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
  std::vector<PlacedBody> places;

  Instant(const ToyScene& scene, Time t) : time(t), T_0v(scene.trajectory->at(t).T_v0.inverse()) {
    places.reserve(scene.world.size());
    for (const ToyBody& body : scene.world) places.push_back(placed(body, t));
  }
  /// What stands is placed already.
  void go_to(const ToyScene& scene, Time t) {
    if (t == time) return;
    time = t;
    T_0v = scene.trajectory->at(t).T_v0.inverse();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!scene.world[i].stands()) places[i] = placed(scene.world[i], t);
    }
  }
};

struct Cast {
  double range_m = 0;
  ReturnCode code = ReturnCode::faulty;
  std::uint32_t label = kLabelUnknown;
};

/// A laser in the frame of the hub: LidarModel::point_v without its sines and cosines for every point.
struct Beam {
  Vector3d origin_h, direction_h;
  [[nodiscard]] Vector3d point_v(const Eigen::Matrix3d& C_vh, double range_m) const {
    return turned(C_vh, origin_h + range_m * direction_h);
  }
};

std::vector<Beam> beams_of(const LidarModel& model) {
  std::vector<Beam> beams;
  for (const Laser& laser : model.lasers) beams.push_back({laser.origin_h_m, laser.direction_h()});
  return beams;
}

Cast cast_ray(const ToyScene& scene, const Beam& beam, const Eigen::Matrix3d& C_vh, const Instant& now) {
  const Vector3d origin_0 = moved(now.T_0v, beam.point_v(C_vh, 0));
  const Vector3d direction_0 = (moved(now.T_0v, beam.point_v(C_vh, 1)) - origin_0).normalized();
  const auto hit = first_hit(scene.world, now.places, origin_0, direction_0);
  if (!hit || hit->range_m > scene.model->max_range_m) return {0, scene.empty_code, kLabelUnknown};
  if (hit->range_m < scene.model->min_range_m) return {};
  const ToyBody& body = scene.world[hit->body];
  const bool moves =
      !body.stands() && body.speed_at(origin_0 + hit->range_m * direction_0, now.time) > kDynamicSpeed_mps;
  const std::uint32_t label =
      moves ? kLabelDynamic | static_cast<std::uint32_t>(body.object) << 16 : kLabelStatic;
  return {hit->range_m, ReturnCode::hit, label};
}

void cast_column(const ToyScene& scene, const std::vector<Beam>& beams, int number, const LidarScan& frame,
                 int column, ToyScan& out) {
  const LidarModel& model = *scene.model;
  const Eigen::Matrix3d C_vh = rotation_z(model.hub_angle(column));
  Instant now(scene, frame.column_time(column));
  for (int laser = 0; laser < frame.rows(); ++laser) {
    const Duration offset = model.lasers[static_cast<std::size_t>(laser)].firing_offset;
    const Time t = frame.column_time(column) + offset;
    now.go_to(scene, t);
    const std::size_t i = static_cast<std::size_t>(laser) * static_cast<std::size_t>(frame.columns) +
                          static_cast<std::size_t>(column);
    const Beam& beam = beams[static_cast<std::size_t>(laser)];
    const Cast cast = cast_ray(scene, beam, C_vh, now);
    const double noise =
        scene.range_noise_m > 0 ? scene.range_noise_m * normal_number(scene.seed, number, i) : 0;
    LidarRecord& record = out.records[i];
    record = {Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()), laser, column,
              static_cast<std::int32_t>((t - frame.start).nanoseconds()), cast.code};
    if (cast.code == ReturnCode::hit)
      record.position_v = beam.point_v(C_vh, cast.range_m + noise).cast<float>();
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
  const std::vector<Beam> beams = beams_of(*scene.model);
  tbb::parallel_for(tbb::blocked_range<int>(0, frame.columns, 16), [&](const tbb::blocked_range<int>& range) {
    for (int column = range.begin(); column < range.end(); ++column)
      cast_column(scene, beams, number, frame, column, out);
  });
  out.scan = std::make_shared<const LidarScan>(organise(frame, out.records, "toy scene"));
  return out;
}

}  // namespace mapless::test
