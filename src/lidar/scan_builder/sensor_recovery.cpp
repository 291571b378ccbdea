#include "lidar/scan_builder/sensor_recovery.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "lidar/nearest_beam.hpp"
#include "lidar/scan_builder/spin_recovery.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Chosen wide: spinning lidars on sale have 16 to 128 lasers and turn 5 to 20 times a second.
constexpr std::size_t kFewestRings = 4;
constexpr std::size_t kMostRings = 256;
constexpr double kSlowest_hz = 1;
constexpr double kFastest_hz = 100;
constexpr double kUsual_hz = 10;  // the default of all drivers
// In spacings between lasers. Points spread evenly between two beams have a median distance of 0.25 to the
// nearer one; this is well below it.
constexpr double kLargestMisfit = 0.15;

[[noreturn]] void refuse(const std::string& source, const std::string& why) {
  throw InputError({source, "sensor", "", "the points do not say which sensor measured them, and " + why,
                    "name it with --sensor, or give its calibration file"});
}

RingSource ring_source(const std::vector<RawPoints>& scans) {
  const auto all = [&](auto holds) { return std::all_of(scans.begin(), scans.end(), holds); };
  if (all([](const RawPoints& p) { return !p.rings.empty(); })) return RingSource::field;
  const std::size_t rows = scans.front().rows;
  if (rows > 1 && all([rows](const RawPoints& p) { return p.rows == rows; })) return RingSource::rows;
  return RingSource::order;
}

// Number of the ring of every point, as the file has it.
std::vector<std::int64_t> ring_numbers(const RawPoints& points, RingSource from) {
  if (from == RingSource::field) return points.rings;
  std::vector<std::int64_t> numbers(points.positions.size(), 0);
  if (from == RingSource::rows) {
    const std::size_t width = std::max<std::size_t>(1, numbers.size() / points.rows);
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int64_t>(i / width);
    return numbers;
  }
  for (const std::size_t start : ring_starts(points.positions)) {
    if (start > 0) numbers[start] = 1;
  }
  std::partial_sum(numbers.begin(), numbers.end(), numbers.begin());
  return numbers;
}

// If the ring numbers increase or decrease with elevation, missing numbers belong to lasers without a return.
void add_unseen_rings(std::vector<std::int64_t>& rings) {
  const bool rise = std::is_sorted(rings.begin(), rings.end());
  if (!rise && !std::is_sorted(rings.rbegin(), rings.rend())) return;
  const auto [least, most] = std::minmax({rings.front(), rings.back()});
  if (least < 0 || most >= static_cast<std::int64_t>(kMostRings)) return;
  rings.resize(static_cast<std::size_t>(most - least) + 1);
  std::iota(rings.begin(), rings.end(), least);
  if (!rise) std::reverse(rings.begin(), rings.end());
}

// The rings of all scans: from the lowest to the highest, so that a ring's neighbours are those in the list;
// in stored order where only the order gives them.
std::vector<std::int64_t> rings_of_scans(const std::vector<RawPoints>& scans, RingSource from,
                                         const std::string& source) {
  std::map<std::int64_t, std::vector<float>> slopes;
  for (const RawPoints& scan : scans) {
    const std::vector<std::int64_t> numbers = ring_numbers(scan, from);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Eigen::Vector3f& p = scan.positions[i];
      if (!is_usable(p)) continue;
      slopes[numbers[i]].push_back(p.z() / p.head<2>().norm());
      if (slopes.size() > kMostRings) refuse(source, "they are not in rings");
    }
  }
  std::vector<std::pair<float, std::int64_t>> by_slope;
  for (auto& [number, s] : slopes) {
    const auto middle = s.begin() + static_cast<std::ptrdiff_t>(s.size() / 2);
    std::nth_element(s.begin(), middle, s.end());
    by_slope.emplace_back(*middle, number);
  }
  if (from != RingSource::order) std::sort(by_slope.begin(), by_slope.end());
  std::vector<std::int64_t> rings;
  for (const auto& [slope, number] : by_slope) rings.push_back(number);
  if (rings.size() < kFewestRings) {
    refuse(source, fmt::format("they show {} rings, too few to recover them", rings.size()));
  }
  if (from != RingSource::order) add_unseen_rings(rings);
  return rings;
}

// Only scans with the most frequent number of rings give them by their order.
void keep_usual_scans(std::vector<RawPoints>& scans) {
  std::map<std::size_t, int> scans_with;
  for (const RawPoints& scan : scans) ++scans_with[ring_starts(scan.positions).size()];
  const auto usual = std::max_element(scans_with.begin(), scans_with.end(),
                                      [](const auto& a, const auto& b) { return a.second <= b.second; });
  const std::size_t count = usual->first;
  std::erase_if(scans, [count](const RawPoints& s) { return ring_starts(s.positions).size() != count; });
}

TimedCloud timed_cloud(const RawPoints& scan, const std::vector<std::int64_t>& rings, RingSource from) {
  std::map<std::int64_t, std::int32_t> index;
  for (const std::int64_t ring : rings) index.emplace(ring, static_cast<std::int32_t>(index.size()));
  const std::vector<std::int64_t> numbers = ring_numbers(scan, from);
  std::vector<std::pair<double, std::size_t>> by_azimuth;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Eigen::Vector3d p = scan.positions[i].cast<double>();
    if (is_usable(scan.positions[i])) by_azimuth.emplace_back(std::atan2(p.y(), p.x()), i);
  }
  std::sort(by_azimuth.begin(), by_azimuth.end());
  TimedCloud cloud;
  for (const auto& [azimuth, i] : by_azimuth) {
    cloud.points.push_back(scan.positions[i]);
    cloud.rings.push_back(index.at(numbers[i]));
    if (!scan.times_ns.empty()) cloud.times_ns.push_back(scan.times_ns[i]);
  }
  return cloud;
}

// Leaves out points that a scan of more than one turn measured twice.
void keep_one_turn(TimedCloud& cloud, double rate_hz) {
  if (cloud.times_ns.empty()) return;
  const std::int64_t first_ns = *std::min_element(cloud.times_ns.begin(), cloud.times_ns.end());
  const std::int64_t turn_ns = Duration::from_seconds(1 / rate_hz).nanoseconds();
  for (std::size_t i = 0; i < cloud.rings.size(); ++i) {
    if (cloud.times_ns[i] - first_ns >= turn_ns) cloud.rings[i] = -1;
  }
}

std::optional<double> rate_of_starts_hz(std::span<const Time> starts) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < starts.size(); ++k) steps.push_back((starts[k] - starts[k - 1]).seconds());
  if (steps.empty()) return std::nullopt;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double rate = 1 / *middle;
  return rate >= kSlowest_hz && rate <= kFastest_hz ? std::optional(rate) : std::nullopt;
}

// Rate and direction, and the note that says where they come from.
std::string take_spin(const std::vector<TimedCloud>& clouds, std::span<const Time> starts,
                      const std::string& source, ModelEstimationOptions& options) {
  if (const std::optional<double> spin = spin_rate_hz(clouds)) {
    options.rotation_rate_hz = std::abs(*spin);
    options.direction = *spin < 0 ? SpinDirection::clockwise : SpinDirection::counter_clockwise;
    if (options.rotation_rate_hz < kSlowest_hz || options.rotation_rate_hz > kFastest_hz) {
      throw InputError({source, "times of the points", fmt::format("{:g} turns a second", std::abs(*spin)),
                        fmt::format("no lidar turns so: not from {:g} to {:g}", kSlowest_hz, kFastest_hz),
                        "give times in nanoseconds (integers) or seconds (floating)"});
    }
    return fmt::format("spin: {} at {:.3f} Hz, from the times of the points",
                       *spin < 0 ? "clockwise" : "counter-clockwise", std::abs(*spin));
  }
  const std::optional<double> rate = rate_of_starts_hz(starts);
  options.rotation_rate_hz = rate.value_or(kUsual_hz);
  return fmt::format(
      "spin: taken as clockwise, from the rear, as no times of points show it; at {:.3f} Hz, {}",
      options.rotation_rate_hz, rate ? "from the starts of the scans" : "as is usual");
}

void require_fit(const std::vector<TimedCloud>& clouds, const RecoveredSensor& sensor,
                 const std::string& source) {
  for (const TimedCloud& cloud : clouds) {
    std::vector<std::int32_t> lasers;
    for (const std::int32_t ring : cloud.rings) {
      lasers.push_back(sensor.layout.row_of_ring[static_cast<std::size_t>(std::max(ring, 0))]);
    }
    std::vector<Eigen::Vector3f> points = cloud.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (cloud.rings[i] < 0) points[i].setZero();  // unusable
    }
    if (beam_misfit(points, lasers, sensor.model) > kLargestMisfit) {
      refuse(source, "they are not stored in rings that lie on the beams of a spinning lidar");
    }
  }
}

std::string sensor_note(const RecoveredSensor& sensor) {
  const char* from = "the order of the points";
  if (sensor.rings_from == RingSource::field) from = "the ring field";
  if (sensor.rings_from == RingSource::rows) from = "the rows of the clouds";
  const ModelEstimate& e = sensor.estimate;
  return fmt::format(
      "sensor: {} lasers from {}; their elevations and vertical origins estimated from {} scans, to {:.2f} "
      "mm "
      "RMS{}; maximum range taken as {:g} m",
      sensor.model.lasers.size(), from, e.scans_used, 1e3 * e.elevation_residual_m,
      e.lasers_borrowed == 0 ? "" : fmt::format(", {} of them borrowed from neighbours", e.lasers_borrowed),
      sensor.model.max_range_m);
}

std::string azimuth_note(const RecoveredSensor& sensor) {
  const ModelEstimate& e = sensor.estimate;
  const std::string grid =
      e.encoder_steps == 0
          ? fmt::format("no grid found; {} columns from the mean step", sensor.model.columns)
          : fmt::format("a grid of {} positions in a turn, {} columns; {} of {} lasers placed on it",
                        e.encoder_steps, sensor.model.columns, e.azimuths_known, sensor.model.lasers.size());
  return fmt::format("azimuths: {}; azimuth offsets {}", grid,
                     e.azimuths_absolute ? "whole" : "to less than a column");
}

}  // namespace

RecoveredSensor recover_sensor(std::vector<RawPoints> scans, std::span<const Time> starts,
                               const std::string& source) {
  RecoveredSensor sensor;
  sensor.rings_from = ring_source(scans);
  if (sensor.rings_from == RingSource::order) keep_usual_scans(scans);
  sensor.rows = scans.front().rows;
  sensor.ring_numbers = rings_of_scans(scans, sensor.rings_from, source);
  std::vector<TimedCloud> clouds;
  for (const RawPoints& scan : scans) {
    clouds.push_back(timed_cloud(scan, sensor.ring_numbers, sensor.rings_from));
  }
  ModelEstimationOptions options;
  options.name = "estimated from the points";
  const std::string spin_note = take_spin(clouds, starts, source, options);
  std::vector<RingedCloud> ringed;
  for (TimedCloud& cloud : clouds) {
    keep_one_turn(cloud, options.rotation_rate_hz);
    ringed.push_back({cloud.points, cloud.rings});
  }
  EstimatedModel estimated = estimate_model_of_rings(ringed, sensor.ring_numbers.size(), options, source);
  sensor.model = std::move(estimated.model);
  sensor.layout = std::move(estimated.layout);
  sensor.estimate = estimated.estimate;
  require_fit(clouds, sensor, source);
  if (!sensor.estimate.azimuths_absolute) {
    sensor.estimate.azimuths_absolute = find_whole_offsets(clouds, sensor.layout.row_of_ring, sensor.model);
  }
  sensor.notes = {sensor_note(sensor), azimuth_note(sensor), spin_note};
  return sensor;
}

std::vector<std::int32_t> lasers_by_rings(const RawPoints& points, const RecoveredSensor& sensor,
                                          const std::string& source) {
  const auto other = [&](const char* field, const std::string& value) {
    return InputError({source, field, value, "not as in the scans the sensor was estimated from",
                       "name the sensor with --sensor, or give its calibration file"});
  };
  if (sensor.rings_from == RingSource::order) {
    return recover_lasers(points.positions, sensor.model, sensor.layout, source);
  }
  if (sensor.rings_from == RingSource::field && points.rings.empty()) throw other("ring", "");
  if (sensor.rings_from == RingSource::rows && points.rows != sensor.rows) {
    throw other("rows", std::to_string(points.rows));
  }
  std::map<std::int64_t, std::int32_t> row_of;
  for (std::size_t i = 0; i < sensor.ring_numbers.size(); ++i) {
    row_of[sensor.ring_numbers[i]] = sensor.layout.row_of_ring[i];
  }
  const std::vector<std::int64_t> numbers = ring_numbers(points, sensor.rings_from);
  std::vector<std::int32_t> lasers(numbers.size(), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!is_usable(points.positions[i])) continue;
    const auto row = row_of.find(numbers[i]);
    if (row == row_of.end()) throw other("ring", std::to_string(numbers[i]));
    lasers[i] = row->second;
  }
  return lasers;
}

}  // namespace mapless
