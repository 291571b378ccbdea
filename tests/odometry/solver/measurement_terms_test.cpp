#include "odometry/solver/measurement_terms.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "odometry/small_problem.hpp"

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDt = 0.1;  // [s] between two knots

std::vector<TrajectoryKnot> knots_with(const Vector6d& varpi_1, const Vector6d& varpi_2) {
  return {{Time::from_seconds(0), SE3(), varpi_1}, {Time::from_seconds(kDt), SE3(), varpi_2}};
}

MotionMeasurement measured(MeasuredMotion quantity, const Eigen::Vector3d& value, double at = 0,
                           double sigma = 0.5) {
  return {Time::from_seconds(at), quantity, value, sigma};
}

Vector6d varpi_of(double x, double y, double z, double rx = 0, double ry = 0, double rz = 0) {
  Vector6d out;
  out << x, y, z, rx, ry, rz;
  return out;
}

// A sensor at r_0v = (2, 0, 0) t that turns by 0.3 rad/s about z has, from the poses themselves, the velocity
// and the angular velocity of which the error is 0.
TEST(MeasurementTerms, TheMotionOfTheSensorIsMeasuredInItsOwnAxes) {
  const auto pose = [](double t) {
    const SE3 turn = SE3::exp(varpi_of(0, 0, 0, 0, 0, 0.3 * t));
    return SE3(turn.rotation(), Eigen::Vector3d(2 * t, 0, 0)).inverse();  // T_v0
  };
  const double t = 1, h = 1e-4;
  const Vector6d varpi = (pose(t + h) * pose(t - h).inverse()).log() / (2 * h);
  const Eigen::Vector3d velocity_v(2 * std::cos(0.3 * t), -2 * std::sin(0.3 * t), 0);
  EXPECT_LT(measurement_error(measured(MeasuredMotion::velocity, velocity_v), varpi).norm(), 1e-6);
  EXPECT_LT(measurement_error(measured(MeasuredMotion::angular_velocity, {0, 0, 0.3}), varpi).norm(), 1e-6);
  EXPECT_LT(measurement_error(measured(MeasuredMotion::speed, {2, 0, 0}), varpi).norm(), 1e-6);
}

// One Gauss-Newton step of a quadratic cost ends at its minimum: the weighted mean of prior and measurement.
TEST(MeasurementTerms, AVelocityAndThePriorAreWeightedByTheirInformation) {
  const auto knots = knots_with(Vector6d::Zero(), Vector6d::Zero());
  const MotionMeasurements all = {measured(MeasuredMotion::velocity, {3, 0, -1}),
                                  measured(MeasuredMotion::angular_velocity, {0, 0.2, 0})};
  WindowSystem system(2);
  for (Matrix12d& block : system.diagonal) block.setIdentity();
  add_measurements(all, knots, 0, system);
  const auto solution = solve(system);
  ASSERT_TRUE(solution);
  // Information 1 of the prior, 1 / 0.5^2 = 4 of the measurement; varpi is minus the motion of the sensor.
  const Vector6d expected = -0.8 * varpi_of(3, 0, -1, 0, 0.2, 0);
  EXPECT_LT((solution->step[0].tail<6>() - expected).norm(), 1e-12);
  EXPECT_LT(solution->step[1].norm(), 1e-12);  // measured at the first knot
}

TEST(MeasurementTerms, TheGradientIsTheDerivativeOfTheCost) {
  std::mt19937 generator(11);
  const auto knots = test::moving_knots(2, generator);
  for (const auto quantity :
       {MeasuredMotion::velocity, MeasuredMotion::speed, MeasuredMotion::angular_velocity}) {
    const MotionMeasurement one = {knots[0].time + Duration::from_seconds(0.03), quantity, {4, 0, 0}, 0.7};
    const auto cost = [&](const TrajectoryKnot& k1, const TrajectoryKnot& k2) -> Eigen::VectorXd {
      const Vector6d varpi = 0.7 * k1.varpi + 0.3 * k2.varpi;
      return Eigen::VectorXd::Constant(1, 0.5 * measurement_error(one, varpi).squaredNorm() / (0.7 * 0.7));
    };
    const Eigen::MatrixXd numerical = test::numerical_jacobian(knots[0], knots[1], cost);
    WindowSystem system(2);
    add_measurements({one}, knots, 0, system);
    Eigen::VectorXd gradient(24);
    gradient << system.gradient[0], system.gradient[1];
    EXPECT_LT((numerical.transpose() - gradient).norm(), 1e-5 * (1 + gradient.norm()));
  }
}

TEST(MeasurementTerms, AMeasurementCountsInOneIntervalOnly) {
  auto knots = knots_with(Vector6d::Zero(), Vector6d::Zero());
  knots.push_back({Time::from_seconds(2 * kDt), SE3(), Vector6d::Zero()});
  WindowSystem system(3);
  const MotionMeasurements all = {measured(MeasuredMotion::velocity, {1, 0, 0}, kDt)};
  add_measurements(all, knots, 0, system);
  EXPECT_EQ(system.gradient[1].norm(), 0);  // that of the next interval
  add_measurements(all, knots, 1, system);
  EXPECT_NEAR(system.gradient[1][6], 1 / 0.25, 1e-12);
}

TEST(MeasurementTerms, ASpeedKnowsNoDirection) {
  const MotionMeasurements all = {measured(MeasuredMotion::speed, {5, 0, 0}, 0.05)};
  for (const Vector6d& varpi : {varpi_of(5, 0, 0), varpi_of(0, -3, 4)})
    EXPECT_FALSE(contradict(knots_with(varpi, varpi), all));
  // Five standard deviations of 0.5 m/s.
  EXPECT_FALSE(contradict(knots_with(varpi_of(7.4, 0, 0), varpi_of(7.4, 0, 0)), all));
  EXPECT_TRUE(contradict(knots_with(varpi_of(7.6, 0, 0), varpi_of(7.6, 0, 0)), all));
}

// At rest the direction of a speed is not known; a speed of 0 holds the sensor in all directions.
TEST(MeasurementTerms, ASpeedAtRest) {
  const auto at_rest = knots_with(Vector6d::Zero(), Vector6d::Zero());
  WindowSystem moving(2), still(2);
  add_measurements({measured(MeasuredMotion::speed, {5, 0, 0})}, at_rest, 0, moving);
  EXPECT_EQ(moving.gradient[0].norm() + moving.diagonal[0].norm(), 0);
  add_measurements({measured(MeasuredMotion::speed, {0, 0, 0})}, at_rest, 0, still);
  EXPECT_NEAR((still.diagonal[0].block<3, 3>(6, 6) - 4 * Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
