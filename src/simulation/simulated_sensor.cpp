#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/argument_checks.hpp"
#include "simulation/random.hpp"
#include <mapless/io/labels.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr double kMaxRangeNoise_m = 10;

// Purpose of a random number: keeps the sequences of noise and faults independent.
enum Purpose : std::uint64_t { kRangeNoise = 1, kFault = 2 };

std::uint64_t counter(int number) { return static_cast<std::uint64_t>(number); }

double normal_number(std::uint64_t bits) {
  const double u = unit_number(bits);
  const double v = unit_number(random_bits({bits}));
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

// Within this range the receiver saturates; beyond, the received power falls with the square of the range.
constexpr double kSaturationRange_m = 20;
// Sensors compensate for part of that fall: this share of the intensity does not depend on range.
constexpr double kRangeFreeIntensity = 0.5;

float intensity_of(const RayHit& hit) {
  const double power =
      std::min(1.0, kSaturationRange_m * kSaturationRange_m / std::max(hit.range_m * hit.range_m, 1.0));
  const double gain = kRangeFreeIntensity + (1 - kRangeFreeIntensity) * power;
  return static_cast<float>(reflectivity(hit.material) * hit.cos_incidence * gain);
}

// Chances of a faulty return. Glass reflects the beam away, dark paint absorbs it; both more so at a slant,
// paint also with range. Chosen: a vehicle then keeps most of its returns and shows holes at windows and dark
// bodies.
constexpr double kGlassFault = 0.6, kGlassFaultBySlant = 0.4;
constexpr double kPaintFault = 0.2, kPaintFaultBySlant = 0.5, kPaintFaultRange_m = 150;
// The received signal is reflectivity x cosine of incidence x (kSignalRange_m / range)^2. Faults begin below
// kFullSignal: asphalt (0.12) seen from 1.95 m above is lost gradually beyond 49 m.
constexpr double kSignalRange_m = 100, kFullSignal = 0.02;

}  // namespace

SimulatedSensor::SimulatedSensor(std::shared_ptr<const LidarModel> model,
                                 std::shared_ptr<const Trajectory> trajectory, SimulatedWorld& world,
                                 SensorOptions options)
    : model_(std::move(model)), trajectory_(std::move(trajectory)), world_(world), options_(options) {
  require_given("SimulatedSensor", "model", model_.get());
  require_given("SimulatedSensor", "trajectory", trajectory_.get());
  validate(*model_, "SimulatedSensor");
  require_between("SimulatedSensor", "range_noise_m", options_.range_noise_m, 0, kMaxRangeNoise_m);
  column_period_ = Duration::from_seconds(1 / model_->rotation_rate_hz / model_->columns);
  for (const Laser& laser : model_->lasers) {
    directions_h_.push_back(laser.direction_h());
    first_firing_ = std::min(first_firing_, laser.firing_offset);
    last_firing_ = std::max(last_firing_, laser.firing_offset);
  }
}

Time SimulatedSensor::firing_time(Time start, int column, int laser) const {
  return start + Duration::from_nanoseconds(column * column_period_.nanoseconds()) +
         model_->lasers[static_cast<std::size_t>(laser)].firing_offset;
}

double SimulatedSensor::fault_probability(const RayHit& hit) const {
  if (!options_.faulty) return 0;
  const double slant = 1 - hit.cos_incidence;
  double probability = 0;
  if (hit.material == Material::glass) probability = kGlassFault + kGlassFaultBySlant * slant;
  if (hit.material == Material::dark_paint)
    probability = kPaintFault + kPaintFaultBySlant * slant + hit.range_m / kPaintFaultRange_m;
  const double signal = reflectivity(hit.material) * hit.cos_incidence * (kSignalRange_m * kSignalRange_m) /
                        (hit.range_m * hit.range_m);
  return std::max(probability, std::clamp(1 - signal / kFullSignal, 0.0, 1.0));
}

void SimulatedSensor::finish_record(int number, int laser, int column, const Eigen::Matrix3d& C_vh,
                                    const std::optional<RayHit>& hit, SimulatedScan& out) const {
  const std::size_t i = static_cast<std::size_t>(laser) * static_cast<std::size_t>(model_->columns) +
                        static_cast<std::size_t>(column);
  LidarRecord& record = out.records[i];
  record.position_v.setConstant(std::numeric_limits<float>::quiet_NaN());
  record.laser = laser;
  record.column = column;
  record.time_ns =
      static_cast<std::int32_t>((firing_time(out.start, column, laser) - out.start).nanoseconds());
  record.code = ReturnCode::nothing;
  if (!hit) return;
  const auto bits = [&](Purpose purpose) {
    return random_bits({options_.seed, purpose, counter(number), counter(laser), counter(column)});
  };
  record.code = ReturnCode::faulty;
  if (hit->range_m < model_->min_range_m) return;
  const double fault = fault_probability(*hit);
  if (fault > 0 && unit_number(bits(kFault)) <= fault) return;
  const double noise =
      options_.range_noise_m > 0 ? options_.range_noise_m * normal_number(bits(kRangeNoise)) : 0;
  record.code = ReturnCode::hit;
  const auto l = static_cast<std::size_t>(laser);
  const Vector3d p_h = model_->lasers[l].origin_h_m + (hit->range_m + noise) * directions_h_[l];
  record.position_v = (C_vh * p_h).cast<float>();
  const bool moves = !hit->carries_sensor && hit->velocity_0.norm() > kDynamicSpeed_mps;
  out.labels[i] = (moves ? kLabelDynamic : kLabelStatic) | static_cast<std::uint32_t>(hit->object_id) << 16;
  out.intensities[i] = intensity_of(*hit);
}

void SimulatedSensor::cast_column(int number, int column, SimulatedScan& out) const {
  const int lasers = static_cast<int>(model_->lasers.size());
  std::vector<TimedRay> rays;
  rays.reserve(model_->lasers.size());
  const Eigen::Matrix3d C_vh = rotation_z(model_->hub_angle(column));
  SE3 T_0h;
  for (int l = 0; l < lasers; ++l) {
    const Laser& laser = model_->lasers[static_cast<std::size_t>(l)];
    const Time t = firing_time(out.start, column, l);
    if (rays.empty() || rays.back().time != t) {
      // The turn of the hub during firing_offset is in the laser's own azimuth.
      T_0h = trajectory_->at(t).T_v0.inverse() * SE3(C_vh, Vector3d::Zero());
    }
    rays.push_back(
        {T_0h * laser.origin_h_m, T_0h.rotation() * directions_h_[static_cast<std::size_t>(l)], t});
  }
  std::vector<std::optional<RayHit>> hits(rays.size());
  world_.cast(rays, model_->max_range_m, hits);
  for (int l = 0; l < lasers; ++l)
    finish_record(number, l, column, C_vh, hits[static_cast<std::size_t>(l)], out);
}

SimulatedScan SimulatedSensor::scan(int number) {
  SimulatedScan out;
  out.start = Time::from_seconds(number / model_->rotation_rate_hz);
  const std::size_t size = model_->lasers.size() * static_cast<std::size_t>(model_->columns);
  out.records.resize(size);
  out.labels.resize(size);
  out.intensities.resize(size);
  const Time begin = out.start + first_firing_;
  const Time end = out.start +
                   Duration::from_nanoseconds((model_->columns - 1) * column_period_.nanoseconds()) +
                   last_firing_;
  const Vector3d first = trajectory_->at(begin).T_v0.inverse().translation();
  const Vector3d last = trajectory_->at(end).T_v0.inverse().translation();
  world_.prepare(begin, end, (first + last) / 2, model_->max_range_m + (last - first).norm() + 1);
  tbb::parallel_for(tbb::blocked_range<int>(0, model_->columns, 32),
                    [&](const tbb::blocked_range<int>& range) {
                      for (int column = range.begin(); column < range.end(); ++column)
                        cast_column(number, column, out);
                    });
  return out;
}

std::shared_ptr<const LidarScan> SimulatedSensor::lidar_scan(int number) { return lidar_scan(scan(number)); }

std::shared_ptr<const LidarScan> SimulatedSensor::lidar_scan(const SimulatedScan& cast) const {
  LidarScan out;
  out.model = model_;
  out.start = cast.start;
  out.column_period = column_period_;
  out.columns = model_->columns;
  return std::make_shared<const LidarScan>(organise(std::move(out), cast.records, "simulated scan"));
}

}  // namespace mapless
