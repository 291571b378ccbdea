#include "io/self_check/motion_check.hpp"

#include <cmath>
#include <functional>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

constexpr int kScans = 40;

// World from sensor as a function of the time in seconds.
using Path = std::function<SE3(double)>;

class PathTrajectory final : public Trajectory {
 public:
  explicit PathTrajectory(Path path) : path_(std::move(path)) {}
  [[nodiscard]] Time begin() const override { return Time::from_seconds(-10); }
  [[nodiscard]] Time end() const override { return Time::from_seconds(100); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    return {path_(t.seconds()).inverse(), Vector6d::Zero()};
  }

 private:
  Path path_;
};

std::shared_ptr<const Trajectory> along(Path path) {
  return std::make_shared<PathTrajectory>(std::move(path));
}

// Ahead at `speed`, the head turning to and fro.
Path walk(double speed) {
  return
      [speed](double t) { return SE3(rotation_z(0.4 * std::sin(2 * t)), Eigen::Vector3d(speed * t, 0, 0)); };
}
Path straight(double speed) {
  return [speed](double t) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(speed * t, 0, 0)); };
}

Path scaled(const Path& path, double factor) {
  return [=](double t) { return SE3(path(t).rotation(), factor * path(t).translation()); };
}

// A recording of a street without traffic along `path`, all of which drifts ahead at `drift` [m/s].
class Recording {
 public:
  explicit Recording(const Path& path, double drift = 0) {
    test::ToyScene scene = test::with_columns(test::toy_street("VLP-16"), 900);
    std::erase_if(scene.world, [](const test::ToyBody& body) { return !body.velocity_0.isZero(); });
    for (test::ToyBody& body : scene.world) body.velocity_0.x() = drift;
    scene.range_noise_m = 0.02;
    scene.trajectory = along(path);
    test::write_toy_sequence(scene, kScans, folder_ / "street");
    dataset_ = open_dataset(folder_ / "street");
  }
  // "pose scale" and "pose times" of poses along `path`.
  [[nodiscard]] std::vector<CheckResult> check(const Path& path) const {
    return check_motion(*dataset_, along(path), 0, dataset_->size(), 3);
  }

 private:
  test::TemporaryFolder folder_;
  std::unique_ptr<Dataset> dataset_;
};

class MotionCheckTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { walked = new Recording(walk(1.2)); }  // NOLINT: lives as long as the suite
  static void TearDownTestSuite() { delete walked; }                   // NOLINT
  static inline const Recording* walked = nullptr;
};

TEST_F(MotionCheckTest, FindsNothingInARightRecording) {
  for (const CheckResult& result : walked->check(walk(1.2))) {
    EXPECT_EQ(result.trust, Trust::right) << result.name << ": " << result.measured;
    EXPECT_EQ(result.problem, "");
  }
}

// 0.12 m/s, and on foot.
TEST_F(MotionCheckTest, FindsPositionsATenthTooLongOrTooShort) {
  const CheckResult longer = walked->check(scaled(walk(1.2), 1.1))[0];
  EXPECT_EQ(longer.trust, Trust::doubtful) << longer.measured;
  EXPECT_THAT(longer.problem, HasSubstr("positions are multiplied by 0.91"));
  const CheckResult shorter = walked->check(scaled(walk(1.2), 0.91))[0];
  EXPECT_EQ(shorter.trust, Trust::doubtful) << shorter.measured;
  EXPECT_THAT(shorter.problem, HasSubstr("positions are multiplied by 1.10"));
}

// What moves along with the sensor at .15 of its speed is sharp with positions .85 times as long. So it is
// sharper with .91 times than with the poses, but .91 is no peak: .82 is sharper, too.
TEST(MotionCheck, DoesNotBelieveAScaleThatIsNoPeak) {
  const CheckResult result = Recording(straight(0.4), 0.15 * 0.4).check(straight(0.4))[0];
  EXPECT_EQ(result.trust, Trust::right) << result.measured;
}

TEST_F(MotionCheckTest, FindsPosesThatAreLateOrEarly) {
  const CheckResult late = walked->check([](double t) { return walk(1.2)(t - 0.1); })[1];
  EXPECT_EQ(late.trust, Trust::doubtful) << late.measured;
  EXPECT_THAT(late.problem, HasSubstr("times of the poses are 0.10 s too late"));
  const CheckResult early = walked->check([](double t) { return walk(1.2)(t + 0.05); })[1];
  EXPECT_EQ(early.trust, Trust::doubtful) << early.measured;
  EXPECT_THAT(early.problem, HasSubstr("times of the poses are 0.05 s too early"));
}

// Along a straight line at one speed late poses are poses of the same motion.
TEST(MotionCheck, DoesNotAskForTheTimesOfASteadyMotion) {
  const Recording street(straight(1.2));
  const std::vector<CheckResult> results = street.check(straight(1.2));
  EXPECT_EQ(results[0].trust, Trust::right) << results[0].measured;
  EXPECT_EQ(results[1].trust, Trust::unknown) << results[1].measured;
  for (const CheckResult& result : street.check([](double) { return SE3(); }))
    EXPECT_EQ(result.trust, Trust::unknown) << result.name << " of a sensor at rest";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
