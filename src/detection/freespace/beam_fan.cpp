#include "detection/freespace/beam_fan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mapless::inline v1 {
namespace {

// Lasers whose origins differ less than this in height are of one bank: from 4 m on the parallax between
// them is below the spacing of any sensor's beams, and nearer the order of two lasers matters little.
constexpr float kBankHeight_m = 0.03F;
// Steps of a bank's table: with 8 a laser, `below` mostly steps once or not at all.
constexpr int kStepsPerLaser = 8;
// Lasers of one elevation have no range of slopes; at least this one keeps the table's step finite.
constexpr float kMinSlopeRange = 1e-3F;
constexpr float kHub_m = 0.5F;      // larger than any sensor: its lasers lie within this of its axis
constexpr float kBeyond_m = 1e30F;  // beyond any return: the search never steps past the last beam

BeamFan::Beam no_beam(float height_m) { return {1, 0, 0, 0, height_m, 0, 0, -1, 1, 0}; }

}  // namespace

BeamFan::BeamFan(const LidarModel& model)
    : columns_per_rad(static_cast<float>(model.sign() * model.columns / (2 * std::numbers::pi))) {
  for (std::size_t l = 0; l < model.lasers.size(); ++l) {
    const Laser& laser = model.lasers[l];
    const double azimuth = laser.azimuth_offset_rad;
    const Eigen::Vector3f origin_l = (rotation_z(-azimuth) * laser.origin_h_m).cast<float>();
    beams.push_back({static_cast<float>(std::cos(laser.elevation_rad)),
                     static_cast<float>(std::sin(laser.elevation_rad)), origin_l.x(), origin_l.y(),
                     origin_l.z(), static_cast<float>(-azimuth) * columns_per_rad,
                     static_cast<float>(model.elevation_step(static_cast<int>(l))), static_cast<int>(l),
                     static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth))});
  }
  for (const Beam& beam : beams) {
    auto bank = std::find_if(banks.begin(), banks.end(),
                             [&](const Bank& b) { return std::abs(b.height_m - beam.up_m) < kBankHeight_m; });
    if (bank == banks.end()) {
      bank = banks.insert(bank, Bank{beam.up_m, 0, 0, {no_beam(-kBeyond_m)}, {}, {}, 0, 0});
    }
    bank->beams.push_back(beam);
    bank->slopes.push_back(beam.sine / beam.cosine);
  }
  for (Bank& bank : banks) {
    bank.centre();
    bank.close();
    bank.offset = static_cast<int>(banked.size());
    banked.insert(banked.end(), bank.beams.begin(), bank.beams.end());
  }
  for (int c = 0; c < model.columns; ++c) turns.push_back(turn_at(model, c));
}

BeamFan::Turn BeamFan::turn_at(const LidarModel& model, int column) {
  const double angle = model.hub_angle(column);
  return {std::cos(angle), std::sin(angle)};
}

void BeamFan::Bank::close() {
  const std::size_t steps = kStepsPerLaser * slopes.size();
  const float range = std::max(slopes.back() - slopes.front(), kMinSlopeRange);
  steps_per_slope = static_cast<float>(steps) / range;
  for (std::size_t k = 0; k <= steps; ++k) {
    const float slope = slopes.front() + static_cast<float>(k) / steps_per_slope;
    const auto first = std::lower_bound(slopes.begin(), slopes.end(), slope);
    at_least.push_back(static_cast<int>(first - slopes.begin()));
  }
  beams.push_back(no_beam(kBeyond_m));
  slopes.push_back(std::numeric_limits<float>::infinity());
}

// Every beam is a line z = rise + slope x. Least squares of rise = z_c - slope x_c.
void BeamFan::Bank::centre() {
  const auto rise = [&](std::size_t k) { return beams[k + 1].up_m - beams[k + 1].ahead_m * slopes[k]; };
  const auto size = static_cast<float>(slopes.size());
  float mean_slope = 0, mean_rise = 0, variance = 0, covariance = 0;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    mean_slope += slopes[k] / size;
    mean_rise += rise(k) / size;
  }
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    variance += (slopes[k] - mean_slope) * (slopes[k] - mean_slope);
    covariance += (slopes[k] - mean_slope) * (rise(k) - mean_rise);
  }
  centre_x_m = variance > 0 ? std::clamp(-covariance / variance, -kHub_m, kHub_m) : 0;
  centre_z_m = mean_rise + centre_x_m * mean_slope;
}

int BeamFan::Bank::below(float slope) const {
  const auto last = static_cast<float>(at_least.size() - 1);
  const float step = std::clamp((slope - slopes.front()) * steps_per_slope, 0.0F, last);
  int count = at_least[static_cast<std::size_t>(step)];
  while (slopes[static_cast<std::size_t>(count)] < slope) ++count;
  return count;
}

}  // namespace mapless
