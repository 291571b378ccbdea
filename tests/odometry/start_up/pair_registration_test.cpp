#include "odometry/start_up/pair_registration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kLasers = 40, kColumns = 600, kEdges = 400;
constexpr double kScan_s = 0.1;
const Eigen::Vector3d kRoom_m(20, 15, 5);  // half the sides

double time_s(int column) { return kScan_s * column / kColumns; }

// Where the ray of a laser ends on the walls of the room, in the sensor frame: p_v(t) = exp(t varpi) p_0.
ScanPoint point_of(int k, int laser, int column, const Vector6d& varpi) {
  const SE3 T_0v = SE3::exp((kScan_s * k + time_s(column)) * varpi).inverse();
  const double azimuth = 2 * std::numbers::pi * column / kColumns;
  const double elevation = 0.02 * (laser - kLasers / 2.0 + 0.5);
  const Eigen::Vector3d direction_v(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Vector3d d_0 = T_0v.rotation() * direction_v;
  double range_m = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    const double to_wall_m = std::copysign(kRoom_m[axis], d_0[axis]) - T_0v.translation()[axis];
    if (d_0[axis] != 0) range_m = std::min(range_m, to_wall_m / d_0[axis]);
  }
  return {(range_m * direction_v).cast<float>(), static_cast<float>(range_m),
          static_cast<std::int32_t>(1e9 * time_s(column)), laser, 0};
}

// `agreeing` of the edges of the second scan are where those of the first would be for a sensor that moves by
// `false_varpi`, the others anywhere.
std::vector<ScanPoint> false_edges(int k, const Vector6d& false_varpi, int agreeing) {
  std::mt19937 shared(5), own(static_cast<unsigned>(10 + k));
  std::uniform_real_distribution<double> metres(-40, 40);
  const auto anywhere = [&](std::mt19937& random) {
    return Eigen::Vector3d(metres(random), metres(random), metres(random));
  };
  std::vector<ScanPoint> out;
  for (int i = 0; i < kEdges; ++i) {
    const Eigen::Vector3d p_0 = anywhere(shared);
    const int column = i * kColumns / kEdges;
    const SE3 T_v0 = SE3::exp((kScan_s * k + time_s(column)) * false_varpi);
    const Eigen::Vector3d p_v = i % (kEdges / agreeing) == 0 ? T_v0 * p_0 : anywhere(own);
    out.push_back({p_v.cast<float>(), static_cast<float>(p_v.norm()),
                   static_cast<std::int32_t>(1e9 * time_s(column)), 0, 0});
  }
  return out;
}

UsableScan scan_of(int k, const Vector6d& varpi, std::vector<ScanPoint> edges) {
  std::vector<ScanPoint> points, keypoints;
  for (int column = 0; column < kColumns; ++column) {
    for (int laser = 0; laser < kLasers; ++laser) {
      points.push_back(point_of(k, laser, column, varpi));
      if ((laser + 7 * column) % 10 == 0) keypoints.push_back(points.back());
    }
  }
  const Time start = Time::from_seconds(kScan_s * k);
  TimeBins bins(keypoints, start, Time());
  return {std::move(points), std::move(bins), std::move(edges), start, static_cast<std::size_t>(k)};
}

// The error of the candidate nearest to `varpi` [m/s].
double least_error_mps(const PairOfScans::Candidates& candidates, const Vector6d& varpi) {
  double least = 1e9;
  for (const Registration& one : candidates.all)
    least = std::min(least, (one.knots.back().varpi - varpi).head<3>().norm());
  return least;
}

PairOfScans::Candidates candidates_of(const Vector6d& varpi, const Vector6d& false_varpi, int agreeing) {
  const UsableScan first = scan_of(0, varpi, false_edges(0, false_varpi, agreeing));
  const UsableScan second = scan_of(1, varpi, false_edges(1, false_varpi, agreeing));
  std::vector<TrajectoryKnot> knots;
  for (int k = 0; k < 3; ++k) knots.push_back({Time::from_seconds(kScan_s * k), SE3(), Vector6d::Zero()});
  WindowPrior prior = origin_prior(knots.front());
  const RegistrationSettings settings = {{0.3, 0.02}, {0.5, 2.5}, 0.02, 1e-4, 15};
  return PairOfScans(knots, prior, first, second, 0, settings).candidates();
}

// Rings of a beam leave edges that move with the sensor. In a tilted recording of a second simulator .155 of
// all edges agreed with a wrong motion, and the right one, which planes admit, was not tried.
TEST(PairOfScans, WhereTheBestEdgesAgreeBadlyAllMotionsOfThePlanesAreCandidates) {
  Vector6d varpi = Vector6d::Zero(), false_varpi = Vector6d::Zero();
  varpi.head<3>() << -2, 0.5, 0.3;
  false_varpi.head<3>() << 20, 5, 0;  // 2 m a scan: far beyond the gate
  const auto badly = candidates_of(varpi, false_varpi, kEdges / 6);
  EXPECT_TRUE(badly.by_edges);
  EXPECT_LT(least_error_mps(badly, varpi), 0.1);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
