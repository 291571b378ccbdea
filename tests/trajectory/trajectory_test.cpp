#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

constexpr std::int64_t kUnixNanoseconds = 1'317'042'272'283'701'593;

Time ms(double milliseconds) { return Time::from_seconds(milliseconds * 1e-3); }

Vector6d random_vector(std::mt19937& random, double translation, double rotation) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = uniform(random) * (i < 3 ? translation : rotation);
  return v;
}

double pose_difference(const SE3& a, const SE3& b) { return (a * b.inverse()).log().norm(); }

// Velocity from poses alone: d/dt T = varpi^ T, by central differences.
Vector6d numeric_velocity(const Trajectory& trajectory, Time t) {
  const Duration h = Duration::from_nanoseconds(50'000);
  const SE3 T_21 = trajectory.at(t + h).T_v0 * trajectory.at(t - h).T_v0.inverse();
  return T_21.log() / (2 * h.seconds());
}

std::vector<TimedPose> random_poses(std::mt19937& random, int count, Time start) {
  std::vector<TimedPose> poses;
  SE3 T_v0 = SE3::exp(random_vector(random, 50, 3));
  for (int i = 0; i < count; ++i) {
    poses.push_back({start + Duration::from_seconds(0.1 * i), T_v0});
    T_v0 = SE3::exp(random_vector(random, 3, 0.4)) * T_v0;
  }
  return poses;
}

std::vector<TrajectoryKnot> random_knots(std::mt19937& random, int count, Time start) {
  std::vector<TrajectoryKnot> knots;
  for (const TimedPose& pose : random_poses(random, count, start)) {
    knots.push_back({pose.time, pose.T_v0, random_vector(random, 30, 4)});
  }
  return knots;
}

TEST(StationaryTrajectory, IsAtTheOriginAtAllTimes) {
  const StationaryTrajectory trajectory;
  for (const Time t :
       {trajectory.begin(), Time(), Time::from_nanoseconds(kUnixNanoseconds), trajectory.end()}) {
    EXPECT_EQ(trajectory.at(t).T_v0.matrix(), Eigen::Matrix4d::Identity());
    EXPECT_EQ(trajectory.at(t).varpi, Vector6d::Zero());
  }
  EXPECT_GT(trajectory.end() - trajectory.begin(), Duration());
}

TEST(SampledTrajectory, PassesThroughItsPoses) {
  std::mt19937 random(1);
  const auto poses = random_poses(random, 8, ms(0));
  const SampledTrajectory trajectory(poses, Duration(), "test");
  for (const TimedPose& pose : poses) {
    EXPECT_LT(pose_difference(trajectory.at(pose.time).T_v0, pose.T_v0), 1e-12);
  }
}

// A screw motion at constant velocity, sampled coarsely, is met exactly in between and beyond.
TEST(SampledTrajectory, ConstantVelocityIsExactWithinAndBeyondTheEnds) {
  std::mt19937 random(2);
  const Vector6d varpi = random_vector(random, 30, 3);
  const SE3 T_start = SE3::exp(random_vector(random, 10, 2));
  const auto truth = [&](Time t) { return SE3::exp(t.seconds() * varpi) * T_start; };
  const SampledTrajectory trajectory(
      {{ms(0), truth(ms(0))}, {ms(100), truth(ms(100))}, {ms(250), truth(ms(250))}},
      Duration::from_seconds(0.1), "test");
  for (double t = -100; t <= 350; t += 10) {
    EXPECT_LT(pose_difference(trajectory.at(ms(t)).T_v0, truth(ms(t))), 1e-10) << t;
    EXPECT_LT((trajectory.at(ms(t)).varpi - varpi).norm(), 1e-9) << t;
  }
}

TEST(SampledTrajectory, VelocityIsTheDerivativeOfThePose) {
  std::mt19937 random(3);
  const SampledTrajectory trajectory(random_poses(random, 6, ms(0)), Duration::from_seconds(0.05), "test");
  for (const double t : {-40.0, 3.0, 50.0, 130.0, 299.0, 455.0, 540.0}) {
    EXPECT_LT((numeric_velocity(trajectory, ms(t)) - trajectory.at(ms(t)).varpi).norm(), 1e-6) << t;
  }
}

// What is beyond single precision would come out of detection as NaN, and be no place in any table.
TEST(SampledTrajectory, PositionsBeyondTheBoundAreRefused) {
  for (const double far_m : {2e8, -1e20, 1e300, std::nan("")}) {
    SCOPED_TRACE(far_m);
    const SE3 T_v0(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, far_m, 0));
    try {
      (void)SampledTrajectory({{ms(0), SE3()}, {ms(1), T_v0}}, Duration(), "poses.txt");
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(error.detail().where, "poses.txt");
      EXPECT_EQ(error.detail().field, "position of pose 1");
    }
  }
}

TEST(SampledTrajectory, RefusesPosesThatAreNoRotationAndANegativeExtrapolation) {
  const SE3 stretched(2 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
  const SE3 mirrored(Eigen::Vector3d(1, 1, -1).asDiagonal(), Eigen::Vector3d::Zero());
  for (const SE3& T : {stretched, mirrored}) {
    try {
      (void)SampledTrajectory({{ms(0), SE3()}, {ms(1), T}}, Duration(), "poses.txt");
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(error.detail().field, "rotation of pose 1");
    }
  }
  EXPECT_THROW(
      SampledTrajectory({{ms(0), SE3()}, {ms(1), SE3()}}, Duration::from_nanoseconds(-1), "poses.txt"),
      ParameterError);
}

TEST(SampledTrajectory, TimesNearTheEndOfTheClockAreRefused) {
  const auto at = [](std::int64_t ns) { return TimedPose{Time::from_nanoseconds(ns), {}}; };
  const std::int64_t last = std::numeric_limits<std::int64_t>::max();
  EXPECT_THROW(SampledTrajectory({at(0), at(last)}, Duration(), "poses.txt"), InputError);
  EXPECT_THROW(SampledTrajectory({at(-last), at(0)}, Duration(), "poses.txt"), InputError);
  EXPECT_THROW(SampledTrajectory({at(0), at(1)}, Duration::from_nanoseconds(last), "poses.txt"),
               ParameterError);
}

TEST(Trajectory, RefusesToSampleBackwardsInTime) {
  const SampledTrajectory sampled({{ms(0), SE3()}, {ms(100), SE3()}}, Duration(), "test");
  const GaussianProcessTrajectory process(
      {{ms(0), SE3(), Vector6d::Zero()}, {ms(100), SE3(), Vector6d::Zero()}}, "test");
  const StationaryTrajectory stationary;
  std::vector<TrajectoryState> states(2);
  for (const Trajectory* trajectory :
       std::initializer_list<const Trajectory*>{&sampled, &process, &stationary}) {
    EXPECT_NO_THROW(trajectory->sample(ms(50), Duration(), states));
    EXPECT_THROW(trajectory->sample(ms(50), Duration::from_nanoseconds(-1), states), ParameterError);
  }
}

TEST(GaussianProcessTrajectory, RefusesVelocitiesThatAreNotFiniteAndSegmentsWithoutLength) {
  const TrajectoryKnot first{ms(0), SE3(), Vector6d::Zero()};
  TrajectoryKnot bad{ms(100), SE3(), Vector6d::Zero()};
  bad.varpi[3] = std::nan("");
  EXPECT_THROW(GaussianProcessTrajectory({first, bad}, "knots"), InputError);
  EXPECT_THROW(KnotSegment(first, first), ParameterError);
}

TEST(SampledTrajectory, OutsideItsDomainThrowsAnErrorThatNamesTheTimes) {
  const SampledTrajectory trajectory({{ms(1000), SE3()}, {ms(2000), SE3()}}, Duration::from_seconds(0.5),
                                     "poses.txt");
  EXPECT_NO_THROW((void)trajectory.at(ms(500)));
  EXPECT_NO_THROW((void)trajectory.at(ms(2500)));
  EXPECT_THROW((void)trajectory.at(Time::from_nanoseconds(499'999'999)), TrajectoryDomainError);
  try {
    (void)trajectory.at(Time::from_nanoseconds(2'500'000'001));
    FAIL();
  } catch (const TrajectoryDomainError& error) {
    for (const char* part : {"poses.txt", "2.500000001 s", "0.500000000 s", "2.500000000 s"}) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

TEST(SampledTrajectory, TimesMustIncrease) {
  const auto make = [](std::vector<TimedPose> poses) {
    SampledTrajectory(std::move(poses), Duration(), "poses.txt");
  };
  EXPECT_THROW(make({}), InputError);
  EXPECT_THROW(make({{ms(0), SE3()}}), InputError);
  EXPECT_THROW(make({{ms(1), SE3()}, {ms(2), SE3()}, {ms(2), SE3()}}), InputError);
  try {
    make({{ms(1), SE3()}, {ms(2), SE3()}, {ms(1.5), SE3()}});
    FAIL();
  } catch (const InputError& error) {
    for (const char* part : {"poses.txt", "pose 2", "0.001500000", "0.002000000"}) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

TEST(GaussianProcessTrajectory, PassesThroughItsKnotsWithTheirVelocities) {
  std::mt19937 random(4);
  const auto knots = random_knots(random, 6, ms(0));
  const GaussianProcessTrajectory trajectory(knots, "test");
  for (const TrajectoryKnot& knot : knots) {
    EXPECT_LT(pose_difference(trajectory.at(knot.time).T_v0, knot.T_v0), 1e-12);
    EXPECT_LT((trajectory.at(knot.time).varpi - knot.varpi).norm(), 1e-9);
  }
}

TEST(GaussianProcessTrajectory, ConstantVelocityIsExact) {
  std::mt19937 random(5);
  const Vector6d varpi = random_vector(random, 30, 3);
  const SE3 T_start = SE3::exp(random_vector(random, 10, 2));
  const auto truth = [&](Time t) { return SE3::exp(t.seconds() * varpi) * T_start; };
  const GaussianProcessTrajectory trajectory(
      {{ms(0), truth(ms(0)), varpi}, {ms(100), truth(ms(100)), varpi}, {ms(300), truth(ms(300)), varpi}},
      "test");
  for (double t = 0; t <= 300; t += 7.5) {
    EXPECT_LT(pose_difference(trajectory.at(ms(t)).T_v0, truth(ms(t))), 1e-11) << t;
    EXPECT_LT((trajectory.at(ms(t)).varpi - varpi).norm(), 1e-9) << t;
  }
}

TEST(GaussianProcessTrajectory, VelocityIsTheDerivativeOfThePoseAndContinuous) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const GaussianProcessTrajectory trajectory(random_knots(random, 4, ms(0)), "test");
    for (double t = 1; t < 300; t += 9) {
      if (std::abs(t - 100) < 1 || std::abs(t - 200) < 1) continue;
      EXPECT_LT((numeric_velocity(trajectory, ms(t)) - trajectory.at(ms(t)).varpi).norm(), 2e-3) << t;
    }
    const Duration ns = Duration::from_nanoseconds(1);
    for (const double t : {100.0, 200.0}) {
      EXPECT_LT((trajectory.at(ms(t) - ns).varpi - trajectory.at(ms(t) + ns).varpi).norm(), 1e-4);
    }
  }
}

// One term of the prior's cost with Qc = diag(50 50 50 5 5 5) (method.md section 3).
double prior_cost(const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  const double dt = (k2.time - k1.time).seconds();
  const Vector6d xi = (k2.T_v0 * k1.T_v0.inverse()).log();
  const Vector6d e1 = xi - dt * k1.varpi;
  const Vector6d e2 = left_jacobian_inverse(xi) * k2.varpi - k1.varpi;
  Vector6d w;
  w << 1. / 50, 1. / 50, 1. / 50, 1. / 5, 1. / 5, 1. / 5;
  const auto dot = [&w](const Vector6d& a, const Vector6d& b) { return a.dot(w.cwiseProduct(b)); };
  return 0.5 * (12 / (dt * dt * dt) * dot(e1, e1) - 12 / (dt * dt) * dot(e1, e2) + 4 / dt * dot(e2, e2));
}

// Gradient of the cost of a third knot put between two, with respect to its pose and velocity.
Eigen::Matrix<double, 12, 1> middle_gradient(const TrajectoryKnot& k1, const TrajectoryKnot& middle,
                                             const TrajectoryKnot& k2) {
  Eigen::Matrix<double, 12, 1> gradient;
  for (int i = 0; i < 12; ++i) {
    const double step = i < 6 ? 1e-6 : 1e-4;
    const auto cost = [&](double h) {
      TrajectoryKnot moved = middle;
      Vector6d d = Vector6d::Zero();
      d[i % 6] = h;
      if (i < 6) {
        moved.T_v0 = SE3::exp(d) * moved.T_v0;
      } else {
        moved.varpi += d;
      }
      return prior_cost(k1, moved) + prior_cost(moved, k2);
    };
    gradient[i] = (cost(step) - cost(-step)) / (2 * step);
  }
  return gradient;
}

// Where translations and rotations commute (a screw axis shared by all motion) the prior is the linear one,
// and the interpolated state is exactly the most probable one: a third knot there has no gradient.
TEST(GaussianProcessTrajectory, InterpolatedStateMinimisesThePriorCost) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto screw = [&](double along, double about) {
      return (Vector6d() << 0, 0, along * uniform(random), 0, 0, about * uniform(random)).finished();
    };
    const SE3 T_start = SE3::exp(screw(5, 1));
    const TrajectoryKnot k1{ms(0), T_start, screw(30, 3)};
    const TrajectoryKnot k2{ms(100), SE3::exp(screw(3, 0.5)) * T_start, screw(30, 3)};
    for (const double t : {13.0, 50.0, 81.0}) {
      const TrajectoryState state = interpolate(k1, k2, ms(t));
      const TrajectoryKnot middle{ms(t), state.T_v0, state.varpi};
      TrajectoryKnot wrong = middle;
      wrong.T_v0 = SE3::exp((Vector6d() << 0, 0, 1e-3, 0, 0, 1e-3).finished()) * wrong.T_v0;
      EXPECT_LT(middle_gradient(k1, middle, k2).norm(), 1e-3 * middle_gradient(k1, wrong, k2).norm()) << t;
    }
  }
}

// For general motion the prior is linear only near the first knot of each interval: the gradient falls with
// the square of the motion, ten times smaller motion a hundred times smaller gradient, where that of a wrong
// state falls ten times.
TEST(GaussianProcessTrajectory, InterpolatedStateMinimisesThePriorCostForSmallMotions) {
  std::mt19937 random(12);
  const Vector6d velocity_1 = random_vector(random, 1, 1), velocity_2 = random_vector(random, 1, 1);
  const Vector6d step = random_vector(random, 0.1, 0.1);
  const auto gradient = [&](double size) {
    const TrajectoryKnot k1{ms(0), SE3(), size * velocity_1};
    const TrajectoryKnot k2{ms(100), SE3::exp(size * step), size * velocity_2};
    const TrajectoryState state = interpolate(k1, k2, ms(40));
    return middle_gradient(k1, {ms(40), state.T_v0, state.varpi}, k2).norm();
  };
  EXPECT_LT(gradient(0.1), 0.02 * gradient(1));
}

TEST(Trajectories, SampleAgreesWithAtForEveryInstant) {
  std::mt19937 random(6);
  const auto knots = random_knots(random, 4, ms(0));
  const GaussianProcessTrajectory process(knots, "test");
  std::vector<TimedPose> poses;
  for (const TrajectoryKnot& knot : knots) poses.push_back({knot.time, knot.T_v0});
  const SampledTrajectory sampled(poses, Duration(), "test");
  const Duration period = (knots.back().time - knots.front().time) * (1.0 / 40);
  for (const Trajectory* trajectory :
       {static_cast<const Trajectory*>(&process), static_cast<const Trajectory*>(&sampled)}) {
    std::vector<TrajectoryState> states(40);
    trajectory->sample(knots.front().time, period, states);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Time t = knots.front().time +
                     Duration::from_nanoseconds(static_cast<std::int64_t>(i) * period.nanoseconds());
      EXPECT_EQ(states[i].T_v0.matrix(), trajectory->at(t).T_v0.matrix());
      EXPECT_EQ(states[i].varpi, trajectory->at(t).varpi);
    }
    trajectory->sample(knots.back().time + period, period, {});
    EXPECT_THROW(trajectory->sample(knots.back().time, period, states), TrajectoryDomainError);
  }
}

TEST(GaussianProcessTrajectory, OutsideItsDomainAndUnorderedKnotsAreErrors) {
  const TrajectoryKnot a{ms(0), SE3(), Vector6d::Zero()}, b{ms(100), SE3(), Vector6d::Zero()};
  const GaussianProcessTrajectory trajectory({a, b}, "odometry");
  EXPECT_EQ(trajectory.begin(), a.time);
  EXPECT_EQ(trajectory.end(), b.time);
  EXPECT_THROW((void)trajectory.at(Time::from_nanoseconds(-1)), TrajectoryDomainError);
  EXPECT_THROW((void)trajectory.at(Time::from_nanoseconds(100'000'001)), TrajectoryDomainError);
  EXPECT_THROW(GaussianProcessTrajectory({a}, "odometry"), InputError);
  EXPECT_THROW(GaussianProcessTrajectory({a, a}, "odometry"), InputError);
  EXPECT_THROW(GaussianProcessTrajectory({b, a}, "odometry"), InputError);
}

TEST(Trajectories, ShiftingAllTimesChangesNothing) {
  std::mt19937 random(8), same(8);
  const Time unix_start = Time::from_nanoseconds(kUnixNanoseconds);
  const Duration shift = unix_start - ms(0);
  const GaussianProcessTrajectory near_zero(random_knots(random, 4, ms(0)), "test");
  const GaussianProcessTrajectory unix(random_knots(same, 4, unix_start), "test");
  std::mt19937 random_2(9), same_2(9);
  const SampledTrajectory sampled_near_zero(random_poses(random_2, 4, ms(0)), Duration(), "test");
  const SampledTrajectory sampled_unix(random_poses(same_2, 4, unix_start), Duration(), "test");
  for (double t = 0; t <= 300; t += 0.37) {
    EXPECT_EQ(near_zero.at(ms(t)).T_v0.matrix(), unix.at(ms(t) + shift).T_v0.matrix());
    EXPECT_EQ(near_zero.at(ms(t)).varpi, unix.at(ms(t) + shift).varpi);
    EXPECT_EQ(sampled_near_zero.at(ms(t)).T_v0.matrix(), sampled_unix.at(ms(t) + shift).T_v0.matrix());
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
