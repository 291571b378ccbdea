#include "support/bare_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

namespace mapless::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGround_m = -1.73;

// Nearest of the ground and a wall whose distance varies with the azimuth.
double range_in_courtyard(double azimuth, const Laser& laser, double scale) {
  const double wall_rho = scale * (14 + 6 * std::sin(3 * azimuth) + 3 * std::cos(7 * azimuth));
  double range = wall_rho / std::cos(laser.elevation_rad);
  if (laser.elevation_rad < 0) {
    // Steps in the ground, so that a ring is not all at one distance.
    const double ground = kGround_m - 0.3 * std::floor(2 + 2 * std::sin(2 * azimuth)) / 4;
    range = std::min(range, (ground - laser.origin_h_m.z()) / std::sin(laser.elevation_rad));
  }
  return range;
}

}  // namespace

LidarModel make_bare_cloud_model(int lasers, int columns) {
  LidarModel model;
  model.name = "made up";
  model.columns = columns;
  model.start_azimuth_rad = kPi;
  model.max_range_m = 120;
  for (int i = 0; i < lasers; ++i) {
    Laser laser;
    laser.elevation_rad = (-20 + 22.0 * i / (lasers - 1)) * kPi / 180;
    laser.azimuth_offset_rad = (-9 + 18.0 * ((i * 7) % lasers) / (lasers - 1)) * kPi / 180;
    const double across = i % 2 == 0 ? 0.026 : -0.026;
    laser.origin_h_m = {-across * std::sin(laser.azimuth_offset_rad),
                        across * std::cos(laser.azimuth_offset_rad), i < lasers / 2 ? 0.12 : 0.20};
    model.lasers.push_back(laser);
  }
  return model;
}

Cloud make_bare_cloud(const LidarModel& model, int encoder_steps, double scale) {
  Cloud cloud;
  for (std::size_t row = model.lasers.size(); row-- > 0;) {
    const Laser& laser = model.lasers[row];
    std::vector<std::pair<double, Eigen::Vector3f>> ring;
    for (int c = 0; c < model.columns; ++c) {
      double turn = static_cast<double>(c) / model.columns;
      if (encoder_steps > 0) turn = std::floor(turn * encoder_steps) / encoder_steps;
      const double hub = model.start_azimuth_rad + model.sign() * 2 * kPi * turn;
      const double range = range_in_courtyard(hub + laser.azimuth_offset_rad, laser, scale);
      const Eigen::Vector3d p = rotation_z(hub) * (laser.origin_h_m + range * laser.direction_h());
      double azimuth = std::atan2(p.y(), p.x());
      if (azimuth < 0) azimuth += 2 * kPi;
      ring.emplace_back(azimuth, p.cast<float>());
    }
    std::sort(ring.begin(), ring.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [azimuth, p] : ring) cloud.push_back(p);
  }
  return cloud;
}

void write_kitti_cloud(const std::filesystem::path& file, const Cloud& cloud) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  for (const Eigen::Vector3f& p : cloud) {
    const float row[4] = {p.x(), p.y(), p.z(), 0};
    out.write(reinterpret_cast<const char*>(row), sizeof row);
  }
}

}  // namespace mapless::test
