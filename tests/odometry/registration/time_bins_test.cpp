#include "odometry/registration/time_bins.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr PointWeights kWeights = {0.5, 2.5};

MapPlane random_plane(std::mt19937& generator, const Vector3d& near_0) {
  std::normal_distribution<double> normal;
  const Vector3d n = Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
  return {near_0 + 0.05 * normal(generator) * n + n.unitOrthogonal(), n, 0.01, 0};
}

Vector3d random_point(std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-20, 20);
  return {uniform(generator), uniform(generator), uniform(generator)};
}

TEST(TimeBins, ResidualAndItsDerivative) {
  std::mt19937 generator(5);
  const auto knots = test::moving_knots(2, generator);
  const Time t = knots[0].time + Duration::from_seconds(0.03);
  const Vector3d p_v = random_point(generator);
  const auto at = KnotInterval(knots[0], knots[1]).at(t);
  const MapPlane plane = random_plane(generator, at.state.T_v0.inverse() * p_v);
  const auto error = [&](const TrajectoryKnot& k1, const TrajectoryKnot& k2) -> Eigen::VectorXd {
    const Vector3d p_0 = interpolate(k1, k2, t).T_v0.inverse() * p_v;
    return Eigen::VectorXd::Constant(1, plane.normal_0.dot(p_0 - plane.point_0));
  };
  const PointResidual residual = point_residual(p_v, at.state.T_v0, plane, kWeights);
  EXPECT_NEAR(residual.error_m, error(knots[0], knots[1])[0], 1e-12);
  const Eigen::MatrixXd numerical = test::numerical_jacobian(knots[0], knots[1], error);
  EXPECT_LT((numerical + residual.a.transpose() * at.pose_jacobian).cwiseAbs().maxCoeff(), 3e-5);
}

// All lasers of a column share one time stamp. Summed before squaring, they would count as one residual.
TEST(TimeBins, SixtyFourPointsAtOneStampAreSixtyFourResiduals) {
  std::mt19937 generator(6);
  const auto knots = test::moving_knots(2, generator);
  const auto at = KnotInterval(knots[0], knots[1]).at(knots[0].time + Duration::from_seconds(0.07));
  BinSums sums;
  sums.T_v0 = at.state.T_v0;
  sums.pose_jacobian = at.pose_jacobian;
  Eigen::Matrix<double, 24, 24> H = Eigen::Matrix<double, 24, 24>::Zero();
  Eigen::Matrix<double, 24, 1> g = Eigen::Matrix<double, 24, 1>::Zero();
  for (int i = 0; i < 64; ++i) {
    const Vector3d p_v = random_point(generator);
    const MapPlane plane = random_plane(generator, at.state.T_v0.inverse() * p_v);
    const PointResidual residual = point_residual(p_v, at.state.T_v0, plane, kWeights);
    sums.add(residual);
    const Eigen::Matrix<double, 1, 24> row = -residual.a.transpose() * at.pose_jacobian;
    H += residual.weight * row.transpose() * row;
    g += residual.weight * row.transpose() * residual.error_m;
  }
  WindowSystem system(2);
  add_points({sums}, 0, 1, system);
  EXPECT_EQ(sums.inliers, 64);
  EXPECT_LT((system.diagonal[0] - H.topLeftCorner<12, 12>()).norm(), 1e-9 * H.norm());
  EXPECT_LT((system.above[0] - H.topRightCorner<12, 12>()).norm(), 1e-9 * H.norm());
  EXPECT_LT((system.diagonal[1] - H.bottomRightCorner<12, 12>()).norm(), 1e-9 * H.norm());
  EXPECT_LT((system.gradient[0] - g.head<12>()).norm(), 1e-9 * g.norm());
  EXPECT_LT((system.gradient[1] - g.tail<12>()).norm(), 1e-9 * g.norm());
}

TEST(TimeBins, ContainEveryPointOnceInShortBins) {
  std::vector<ScanPoint> keypoints;
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<float>(i);
    keypoints.push_back({{x, 0, 0}, x, 100'000 * i, 0, static_cast<std::uint32_t>(i)});
  }
  const Time start = Time::from_seconds(5);
  const TimeBins bins(keypoints, start, start + Duration::from_seconds(0.01));
  EXPECT_EQ(bins.points().size(), 900u);
  EXPECT_EQ(bins.bins().size(), 32u);
  std::size_t next = 0;
  for (const auto& bin : bins.bins()) {
    EXPECT_EQ(bin.begin, next);
    next = bin.end;
    for (std::size_t i = bin.begin; i < bin.end; ++i) {
      const double time = (bin.time - start).seconds() + bins.points()[i].dt;
      EXPECT_NEAR(time, 1e-4 * bins.points()[i].position_v.x(), 1e-12);
      EXPECT_LT(std::abs(bins.points()[i].dt), 0.5 * 0.09 / 32 + 1e-9);
    }
  }
  EXPECT_EQ(next, 900u);
}

TEST(TimeBins, ReversedHasTheSamePointsAtOppositeTimes) {
  std::vector<ScanPoint> keypoints;
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<float>(i);
    keypoints.push_back({{x, 0, 0}, x, 100'000 * i + i * i, 0, static_cast<std::uint32_t>(i)});
  }
  const TimeBins reversed = TimeBins(keypoints, Time::from_seconds(5), Time()).reversed();
  ASSERT_EQ(reversed.points().size(), 1000u);
  std::size_t next = 0;
  for (const auto& bin : reversed.bins()) {
    EXPECT_EQ(bin.begin, next);
    next = bin.end;
    for (std::size_t i = bin.begin; i < bin.end; ++i) {
      const TimeBins::Point& point = reversed.points()[i];
      const ScanPoint& keypoint = keypoints[999 - i];
      EXPECT_EQ(point.position_v.x(), keypoint.position_v.x());
      EXPECT_NEAR(bin.time.seconds() + point.dt, -(5 + 1e-9 * keypoint.time_ns), 1e-9);
    }
  }
  EXPECT_EQ(next, 1000u);
}

TEST(TimeBins, BeforeHasTheFirstBins) {
  std::vector<ScanPoint> keypoints;
  for (int i = 0; i < 320; ++i) keypoints.push_back({{0, 0, 0}, 1, 1'000'000 * i, 0, 0});
  const Time start = Time::from_seconds(5);
  const TimeBins half = TimeBins(keypoints, start, Time()).before(start + Duration::from_seconds(0.16));
  EXPECT_EQ(half.bins().size(), 16u);
  EXPECT_EQ(half.points().size(), 160u);
  EXPECT_EQ(half.bins().back().end, 160u);
  EXPECT_TRUE(TimeBins(keypoints, start, Time()).before(start).bins().empty());
}

// The weight of the Cauchy loss k^2/2 log(1 + r^2/k^2) of r = error / sigma, divided by sigma^2.
TEST(TimeBins, WeightsFollowTheNoiseAndTheCauchyLoss) {
  const MapPlane plane = {Vector3d::Zero(), Vector3d::UnitZ(), 0.04, 0};
  EXPECT_NEAR(point_residual({0, 0, 0}, SE3(), plane, kWeights).weight, 25, 1e-12);
  const PointResidual off = point_residual({3, -2, 0.4}, SE3(), plane, kWeights);
  EXPECT_NEAR(off.weight, 25 / (1 + 2 * 2 / (2.5 * 2.5)), 1e-12);
  EXPECT_NEAR(off.robust_weight, 1 / (1 + 2 * 2 / (2.5 * 2.5)), 1e-12);
  EXPECT_EQ(point_residual({0, 0, 0.6}, SE3(), plane, kWeights).weight, 0) << "beyond the gate";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
