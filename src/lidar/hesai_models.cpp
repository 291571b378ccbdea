#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "lidar/vendor_models.hpp"

namespace mapless::inline v1 {
namespace {

// Elevation and azimuth of the channels, from the vendor's angle correction files [deg]; azimuth clockwise
// positive.
constexpr std::array<double, 64> kPandar64Elevation = {
    14.9,   11.05,  8.077,   5.075,   3.058,   2.046,   1.878,   1.706,   1.54,   1.369,  1.202,
    1.031,  0.864,  0.693,   0.526,   0.355,   0.187,   0.018,   -0.151,  -0.319, -0.49,  -0.657,
    -0.827, -0.995, -1.166,  -1.333,  -1.504,  -1.67,   -1.842,  -2.01,   -2.18,  -2.347, -2.518,
    -2.682, -2.855, -3.022,  -3.192,  -3.357,  -3.53,   -3.694,  -3.866,  -4.032, -4.203, -4.367,
    -4.54,  -4.702, -4.874,  -5.039,  -5.211,  -5.373,  -5.547,  -5.708,  -5.88,  -6.043, -7.045,
    -8.041, -9.042, -10.027, -11.014, -11.988, -12.956, -13.912, -18.871, -24.879};
constexpr std::array<double, 64> kPandar64Azimuth = {
    -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, 1.042,  3.125,  5.208,  -5.208, -3.125, -1.042, 1.042,
    3.125,  5.208,  -5.208, -3.125, -1.042, 1.042,  3.125,  5.208,  -5.208, -3.125, -1.042, 1.042,  3.125,
    5.208,  -5.208, -3.125, -1.042, 1.042,  3.125,  5.208,  -5.208, -3.125, -1.042, 1.042,  3.125,  5.208,
    -5.208, -3.125, -1.042, 1.042,  3.125,  5.208,  -5.208, -3.125, -1.042, 1.042,  3.125,  5.208,  -5.208,
    -3.125, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042};

constexpr std::array<double, 32> kXt32Elevation = {
    14.972363, 13.952372,  12.938632, 11.931141,  10.926151,  9.92241,    8.917419,   7.917429,
    6.919938,  5.919947,   4.922456,  3.924965,   2.929974,   1.936233,   0.944992,   -0.0475,
    -1.039991, -2.036232,  -3.028723, -4.024964,  -5.019955,  -6.016196,  -7.013687,  -8.013678,
    -9.011169, -10.011159, -11.00615, -12.003641, -12.996131, -13.997372, -15.004862, -16.023602};
constexpr std::array<double, 32> kXt32Azimuth = {
    0.082385,  0.076529,  0.07824,   0.076267,  0.064337,  0.059942,  0.049319,  0.044992,
    0.034446,  0.027658,  0.020896,  0.014147,  0.008668,  -0.000548, -0.007248, -0.015201,
    -0.025654, -0.031126, -0.037837, -0.045822, -0.061312, -0.06557,  -0.068599, -0.076658,
    -0.088476, -0.09158,  -0.098438, -0.092837, -0.102247, -0.104231, -0.118783, -0.129679};

// When each channel fires, before its block's end [ns] (the manual's table).
constexpr std::array<int, 64> kPandar64FiringNs = {
    -23180, -21876, -20572, -19268, -17964, -16660, -11444, -46796, -7532,  -36956, -50732, -54668, -40892,
    -44828, -31052, -34988, -48764, -52700, -38924, -42860, -29084, -33020, -46796, -25148, -36956, -50732,
    -27116, -40892, -44828, -31052, -34988, -48764, -25148, -38924, -42860, -29084, -33020, -52700, -6228,
    -54668, -15356, -27116, -10140, -23180, -4924,  -21876, -14052, -17964, -8836,  -19268, -3620,  -20572,
    -12748, -16660, -7532,  -11444, -6228,  -15356, -10140, -4924,  -3620,  -14052, -8836,  -12748};

// A spinning sensor, by its channels and whether the highest is beyond 50 degrees (the QT): columns at 10 Hz
// and ranges are the manual's.
struct HesaiSensor {
  std::size_t channels;
  bool wide;
  int columns;
  double min_range_m, max_range_m;
};
constexpr std::array<HesaiSensor, 7> kSensors = {{{16, false, 2000, 0.05, 120},
                                                  {32, false, 2000, 0.05, 120},
                                                  {40, false, 1800, 0.3, 200},
                                                  {64, false, 1800, 0.3, 200},
                                                  {64, true, 600, 0.1, 60},
                                                  {128, false, 1800, 0.3, 200},
                                                  {128, true, 900, 0.05, 50}}};
constexpr double kWide_deg = 50;
// The AT128 has 128 channels too, none of them higher; it does not turn.
constexpr double kHighestOfAt128_deg = 13;
// The XT-32M has as many channels as the XT-32, from 19.4 degrees down.
constexpr double kHighestOfXt32_deg = 16;

// Hesai's frame has y forward; the optical centre, given there as (x, y), turns with the hub.
struct Timing {
  Eigen::Vector2d centre_m = {0, 0};
  std::vector<Duration> firing;  // of each channel
};

// Of the sensors whose manual we have; else all channels fire with the column, from the axis.
Timing timing_of(std::size_t channels, double highest_deg) {
  Timing timing;
  timing.firing.resize(channels);
  if (channels == 64 && highest_deg < kWide_deg) {
    timing.centre_m = {-0.012, 0.039};
    for (std::size_t i = 0; i < channels; ++i)
      timing.firing[i] = Duration::from_nanoseconds(kPandar64FiringNs[i]);
  }
  if (channels == 32 && highest_deg < kHighestOfXt32_deg) {
    timing.centre_m = {-0.013, 0.032};
    for (std::size_t i = 0; i < channels; ++i)
      timing.firing[i] = Duration::from_seconds(6e-6 + 1.512e-6 * static_cast<double>(i));
  }
  return timing;
}

}  // namespace

LidarModel hesai_model(std::span<const double> elevation_deg, std::span<const double> azimuth_deg) {
  LidarModel model;
  model.start_azimuth_rad = radians(90);
  if (elevation_deg.empty()) return model;
  const std::size_t channels = elevation_deg.size();
  const double highest_deg = *std::max_element(elevation_deg.begin(), elevation_deg.end());
  const auto sensor = std::find_if(kSensors.begin(), kSensors.end(), [&](const HesaiSensor& s) {
    return s.channels == channels && s.wide == (highest_deg > kWide_deg);
  });
  if (sensor == kSensors.end() || (channels == 128 && highest_deg < kHighestOfAt128_deg)) return model;
  model.columns = sensor->columns;
  model.min_range_m = sensor->min_range_m;
  model.max_range_m = sensor->max_range_m;
  const Timing timing = timing_of(channels, highest_deg);
  for (std::size_t i = 0; i < channels; ++i) {
    Laser laser;
    laser.elevation_rad = radians(elevation_deg[i]);
    laser.azimuth_offset_rad = radians(-azimuth_deg[i]);
    laser.origin_h_m = {timing.centre_m.y(), -timing.centre_m.x(), 0};
    laser.firing_offset = timing.firing[i];
    model.lasers.push_back(laser);
  }
  return assembled(std::move(model));
}

LidarModel pandar_64() { return hesai_model(kPandar64Elevation, kPandar64Azimuth); }
LidarModel xt_32() { return hesai_model(kXt32Elevation, kXt32Azimuth); }

}  // namespace mapless
