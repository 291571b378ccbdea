#include "lidar/recovery/firing_offsets.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "support/bare_cloud.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr double kTurn_s = 0.1;

// The sensor during a turn, from its frame in the middle of it.
std::vector<SE3> turn_at(const Vector6d& velocity) {
  std::vector<SE3> T_vc;
  for (int i = 0; i < 1000; ++i) T_vc.push_back(SE3::exp(-((i + 0.5) / 1000 - 0.5) * kTurn_s * velocity));
  return T_vc;
}

// A turn in a courtyard as measured, and taken to its middle by the instants of its firings.
struct Turn {
  Turn(const LidarModel& model, const Vector6d& velocity, double scale)
      : measured(test::make_bare_cloud(model, 0, scale)) {
    compensated.T_vc = turn_at(velocity);
    const std::size_t lasers = model.lasers.size(), of_ring = measured.size() / lasers;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const std::size_t ring = i / of_ring;
      const Laser& laser = model.lasers[lasers - 1 - ring];
      const Eigen::Vector3d p = measured[i].cast<double>();
      const double across = laser.origin_h_m.head<2>().norm() * ((lasers - 1 - ring) % 2 == 0 ? 1 : -1);
      const double subtended = std::asin(across / p.head<2>().norm());
      const double hub =
          std::remainder(std::atan2(p.y(), p.x()) - laser.azimuth_offset_rad - subtended, 2 * kPi);
      const double turn = (1 - hub / kPi) / 2;
      const SE3 T_vc = SE3::exp(-(turn - 0.5) * kTurn_s * velocity);
      compensated.cloud.points.push_back((T_vc.inverse() * p).cast<float>());
      compensated.cloud.rings.push_back(static_cast<std::int32_t>(ring));
    }
  }
  test::Cloud measured;
  CompensatedCloud compensated;
};

std::vector<double> offsets_of(const LidarModel& model) {
  std::vector<double> out;
  for (auto laser = model.lasers.rbegin(); laser != model.lasers.rend(); ++laser)
    out.push_back(laser->azimuth_offset_rad);
  return out;
}

TEST(FiringOffsets, ThePointsOfMovingLasersTellThemToAColumnOrTwo) {
  const LidarModel model = test::make_bare_cloud_model(32, 1800);
  Vector6d velocity;
  velocity << 14, 0.3, 0, 0.01, 0, 0.2;
  std::vector<CompensatedCloud> clouds;
  for (const double scale : {1.0, 1.3, 1.7}) clouds.push_back(Turn(model, velocity, scale).compensated);
  const auto found = find_firing_offsets(clouds, model.lasers.size());
  ASSERT_TRUE(found);
  const std::vector<double> expected = offsets_of(model);
  for (std::size_t r = 0; r < expected.size(); ++r)
    EXPECT_NEAR((*found)[r], expected[r], kDegree) << "ring " << r;
}

TEST(FiringOffsets, AStandingSensorTellsNone) {
  const LidarModel model = test::make_bare_cloud_model(32, 1800);
  const auto found = find_firing_offsets({Turn(model, Vector6d::Zero(), 1).compensated}, model.lasers.size());
  ASSERT_TRUE(found);
  for (const double offset : *found) EXPECT_EQ(offset, 0);
}

TEST(FiringOffsets, WithThemThePointsAreThoseMeasured) {
  const LidarModel model = test::make_bare_cloud_model(32, 1800);
  Vector6d velocity;
  velocity << 14, 0.3, 0, 0.01, 0, 0.2;
  const Turn turn(model, velocity, 1);
  const test::Cloud points = measured_points(turn.compensated, offsets_of(model));
  std::size_t off = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // At most half of a part of the turn off: 0.7 mm; and 0.026 m of horizontal origin at 5 m: 1.2 mm.
    if ((points[i] - turn.measured[i]).norm() > 2e-3) ++off;
  }
  EXPECT_LT(off, points.size() / 1000);  // at the seam: of the begin of the turn, or of its end
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
