#include "lidar/scan_builder/spin_recovery.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/median.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;
// Azimuth steps that measure the rate: long against the angle of a horizontal origin (0.03 m at 5 m: 6 mrad)
// and the rounding of an encoder (1.6 mrad); short enough that their direction is unambiguous if most returns
// are missing.
constexpr double kShortestStep_rad = 0.1;
constexpr double kLongestStep_rad = 0.5;
// Chosen: a median of fewer steps can be moved by one outlier in ten.
constexpr std::size_t kFewestSteps = 20;
// Bins of a turn (5.6 degrees each) within which the rotation rate is taken as constant.
constexpr int kBins = 64;

double azimuth_of(const Eigen::Vector3f& p) {
  return std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x()));
}

void add_rates(const TimedCloud& cloud, std::vector<double>& rates) {
  std::vector<std::size_t> by_time(cloud.points.size());
  std::iota(by_time.begin(), by_time.end(), std::size_t{0});
  std::stable_sort(by_time.begin(), by_time.end(),
                   [&](std::size_t a, std::size_t b) { return cloud.times_ns[a] < cloud.times_ns[b]; });
  std::vector<std::optional<std::size_t>> from;  // first point of the current step, per ring
  for (const std::size_t i : by_time) {
    if (cloud.rings[i] < 0) continue;
    const auto ring = static_cast<std::size_t>(cloud.rings[i]);
    if (ring >= from.size()) from.resize(ring + 1);
    if (!from[ring]) from[ring] = i;
    const double step =
        std::remainder(azimuth_of(cloud.points[i]) - azimuth_of(cloud.points[*from[ring]]), kTurn_rad);
    if (std::abs(step) < kShortestStep_rad) continue;
    const auto time_ns = static_cast<double>(cloud.times_ns[i] - cloud.times_ns[*from[ring]]);
    from[ring] = i;
    if (std::abs(step) < kLongestStep_rad && time_ns > 0)
      rates.push_back(step / kTurn_rad / (1e-9 * time_ns));
  }
}

double across_of(const Laser& laser) {
  return laser.origin_h_m.y() * std::cos(laser.azimuth_offset_rad) -
         laser.origin_h_m.x() * std::sin(laser.azimuth_offset_rad);
}

// Azimuth of each point minus the rotation of the hub since the start of the scan and the angle of the
// horizontal origin: the azimuth offset of its laser plus a term common to all lasers.
std::vector<double> offsets_of_points(const TimedCloud& cloud, const std::vector<int>& row_of_ring,
                                      const LidarModel& model, std::int64_t first_ns) {
  std::vector<double> offsets(cloud.points.size(), 0);
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (cloud.rings[i] < 0) continue;
    const int row = row_of_ring[static_cast<std::size_t>(cloud.rings[i])];
    const double rho_m = std::sqrt(cloud.points[i].head<2>().cast<double>().squaredNorm());
    const double across = across_of(model.lasers[static_cast<std::size_t>(row)]) / rho_m;
    const double turns = 1e-9 * static_cast<double>(cloud.times_ns[i] - first_ns) * model.rotation_rate_hz;
    offsets[i] = azimuth_of(cloud.points[i]) - std::asin(std::clamp(across, -1.0, 1.0)) -
                 model.sign() * kTurn_rad * turns;
  }
  return offsets;
}

std::size_t bin_of(std::int64_t since_first_ns, const LidarModel& model) {
  const double turns = 1e-9 * static_cast<double>(since_first_ns) * model.rotation_rate_hz;
  return static_cast<std::size_t>(std::clamp(turns, 0.0, 1.0 - 0.5 / kBins) * kBins);
}

// Appends, ring by ring, the offsets of its points minus that of the reference ring in the same bin of the
// turn.
void add_differences(const TimedCloud& cloud, const std::vector<int>& row_of_ring, const LidarModel& model,
                     std::int32_t reference, std::vector<std::vector<double>>& differences) {
  if (cloud.times_ns.empty()) return;
  const std::int64_t first_ns = *std::min_element(cloud.times_ns.begin(), cloud.times_ns.end());
  const std::vector<double> offsets = offsets_of_points(cloud, row_of_ring, model, first_ns);
  std::array<std::vector<double>, kBins> of_reference;
  std::optional<double> around;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (cloud.rings[i] != reference) continue;
    if (!around) around = offsets[i];
    of_reference[bin_of(cloud.times_ns[i] - first_ns, model)].push_back(
        std::remainder(offsets[i] - *around, kTurn_rad));
  }
  if (!around) return;
  std::array<double, kBins> middle{};
  for (std::size_t b = 0; b < kBins; ++b) {
    if (!of_reference[b].empty()) middle[b] = *around + median(of_reference[b]);
  }
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const std::size_t b = bin_of(cloud.times_ns[i] - first_ns, model);
    if (cloud.rings[i] < 0 || of_reference[b].empty()) continue;
    differences[static_cast<std::size_t>(cloud.rings[i])].push_back(
        std::remainder(offsets[i] - middle[b], kTurn_rad));
  }
}

std::int32_t fullest_ring(const std::vector<TimedCloud>& clouds, std::size_t count) {
  std::vector<std::size_t> sizes(count, 0);
  for (const TimedCloud& cloud : clouds) {
    for (const std::int32_t ring : cloud.rings) {
      if (ring >= 0) ++sizes[static_cast<std::size_t>(ring)];
    }
  }
  return static_cast<std::int32_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
}

}  // namespace

std::optional<double> spin_rate_hz(const std::vector<TimedCloud>& clouds) {
  std::vector<double> rates;
  for (const TimedCloud& cloud : clouds) {
    if (!cloud.times_ns.empty()) add_rates(cloud, rates);
  }
  if (rates.size() < kFewestSteps) return std::nullopt;
  return median(std::move(rates));
}

bool find_whole_offsets(const std::vector<TimedCloud>& clouds, const std::vector<int>& row_of_ring,
                        LidarModel& model) {
  const std::size_t count = row_of_ring.size();
  const std::int32_t reference = fullest_ring(clouds, count);
  std::vector<std::vector<double>> differences(count);
  for (const TimedCloud& cloud : clouds) add_differences(cloud, row_of_ring, model, reference, differences);
  std::vector<std::optional<double>> offsets(count);
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (std::size_t ring = 0; ring < count; ++ring) {
    if (differences[ring].empty()) continue;
    offsets[ring] = median(std::move(differences[ring]));
    least = std::min(least, *offsets[ring]);
    most = std::max(most, *offsets[ring]);
  }
  if (least > most) return false;
  const double centre = (least + most) / 2;
  const double column = kTurn_rad / model.columns;
  for (std::size_t ring = 0; ring < count; ++ring) {
    if (!offsets[ring]) continue;
    Laser& laser = model.lasers[static_cast<std::size_t>(row_of_ring[ring])];
    const double across = across_of(laser);
    const double whole = std::round((*offsets[ring] - centre - laser.azimuth_offset_rad) / column);
    laser.azimuth_offset_rad += whole * column;
    laser.origin_h_m.x() = -across * std::sin(laser.azimuth_offset_rad);
    laser.origin_h_m.y() = across * std::cos(laser.azimuth_offset_rad);
  }
  return true;
}

}  // namespace mapless
