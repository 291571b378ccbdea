#include "odometry/solver/secant_steps.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

Vector12d along(int axis, double amount) { return amount * Vector12d::Unit(axis); }

// A linear iteration whose steps shrink by a twentieth along one direction of two knots and to a tenth along
// another: where its steps vanish is known. Left to itself it is .95^10 = 60 % off after ten steps.
struct SlowIteration {
  Vector12d first = along(0, 1), second = along(2, -0.5);

  [[nodiscard]] std::vector<Vector12d> step() const {
    Vector12d one = -0.05 * first, two = -0.05 * second;
    one[1] = -0.9 * first[1];
    return {one, two};
  }
  void move(const std::vector<Vector12d>& by) {
    first += by[0];
    second += by[1];
  }
  [[nodiscard]] double distance() const { return std::hypot(first.norm(), second.norm()); }
};

TEST(SecantSteps, GoToThePlaceWhereStepsVanish) {
  SlowIteration plain, fast;
  plain.first[1] = fast.first[1] = 0.01;
  SecantSteps steps;
  for (int i = 0; i < 10; ++i) {
    plain.move(plain.step());
    fast.move(steps.extrapolated(fast.step()));
  }
  EXPECT_NEAR(plain.distance(), std::pow(0.95, 10) * std::hypot(1, 0.5), 1e-3);
  EXPECT_LT(fast.distance(), 0.01);
}

TEST(SecantSteps, TwoStepsTellThePlaceIfItIsNear) {
  SecantSteps steps;
  const std::vector<Vector12d> first = {along(1, 0.4)}, second = {along(1, 0.3)};
  EXPECT_EQ(steps.extrapolated(first), first);
  EXPECT_FALSE(steps.has_extrapolated());
  // .4 + .3 + .225 + ... = 1.6 in all
  EXPECT_NEAR(steps.extrapolated(second).front()[1], 1.2, 1e-12);
  EXPECT_TRUE(steps.has_extrapolated());
}

TEST(SecantSteps, StepsThatDoNotShrinkAreLengthenedToALimit) {
  for (const double next : {0.4, 0.5}) {
    SecantSteps steps;
    (void)steps.extrapolated({along(0, 0.4)});
    const double taken = steps.extrapolated({along(0, next)}).front()[0];
    EXPECT_GT(taken, 8 * next);
    EXPECT_LT(taken, 12 * next);
  }
}

// Turns count as well: by 10 m, the distance of a point that moves as much by either.
TEST(SecantSteps, OneInAnotherDirectionIsTakenAsItIs) {
  const std::vector<Vector12d> first = {along(0, 0.4)};
  for (const std::vector<Vector12d>& other :
       {std::vector{along(1, 0.3)}, {along(0, -0.3)}, {Vector12d(along(0, 0.3) + along(4, 0.03))}}) {
    SecantSteps steps;
    (void)steps.extrapolated(first);
    EXPECT_EQ(steps.extrapolated(other), other);
    EXPECT_FALSE(steps.has_extrapolated());
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
