#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/core/se3.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

constexpr int kScans = 12;

// A trajectory whose poses are changed.
class SpoiltTrajectory final : public Trajectory {
 public:
  SpoiltTrajectory(std::shared_ptr<const Trajectory> right, std::function<SE3(Time, const SE3&)> spoil)
      : right_(std::move(right)), spoil_(std::move(spoil)) {}
  [[nodiscard]] Time begin() const override { return right_->begin(); }
  [[nodiscard]] Time end() const override { return right_->end(); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    return {spoil_(t, right_->at(t).T_v0.inverse()).inverse(), Vector6d::Zero()};
  }

 private:
  std::shared_ptr<const Trajectory> right_;
  std::function<SE3(Time, const SE3&)> spoil_;
};

class SelfCheckTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared = new test::TemporaryFolder;  // NOLINT: lives as long as the suite
    test::write_toy_sequence(test::toy_street("VLP-16"), kScans, *shared / "street");
  }
  static void TearDownTestSuite() { delete shared; }  // NOLINT

  [[nodiscard]] std::vector<CheckResult> check(const std::shared_ptr<const Trajectory>& given) const {
    return check_recording(*street, given, 0, street->size());
  }
  // Of poses T_0v changed by `spoil`.
  [[nodiscard]] CheckResult check_poses_of(const std::function<SE3(Time, const SE3&)>& spoil) const {
    return check(std::make_shared<SpoiltTrajectory>(street->trajectory(), spoil)).back();
  }

  static inline const test::TemporaryFolder* shared = nullptr;
  std::unique_ptr<Dataset> street = open_dataset(*shared / "street");
};

TEST_F(SelfCheckTest, FindsNothingInARightRecording) {
  for (const CheckResult& result : check(street->trajectory())) {
    // The velocity hardly changes within a second.
    const Trust expected = result.name == "pose times" ? Trust::unknown : Trust::right;
    EXPECT_EQ(result.trust, expected) << result.name << ": " << result.measured << result.problem;
    EXPECT_EQ(result.problem, "");
  }
}

TEST_F(SelfCheckTest, DoesNotCheckPosesThatAreNotGiven) {
  EXPECT_EQ(check(nullptr).back().trust, Trust::unknown);
}

TEST_F(SelfCheckTest, FindsPosesThatAreInverted) {
  const CheckResult poses = check_poses_of([](Time, const SE3& T) { return T.inverse(); });
  EXPECT_EQ(poses.trust, Trust::wrong) << poses.measured;
  EXPECT_THAT(poses.problem, HasSubstr("poses look inverted"));
  EXPECT_THROW(require_trusted({poses}), InputError);
}

TEST_F(SelfCheckTest, FindsPositionsInMillimetres) {
  const CheckResult poses =
      check_poses_of([](Time, const SE3& T) { return SE3(T.rotation(), 1000 * T.translation()); });
  EXPECT_EQ(poses.trust, Trust::wrong) << poses.measured;
  EXPECT_THAT(poses.problem, HasSubstr("positions look like millimetres"));
}

// Vehicles that fill the view and move along look like a world that is slower than the poses, the same way.
TEST_F(SelfCheckTest, DoubtsPosesThatAreFasterThanAllThatIsSeen) {
  const auto faster = [](double times) {
    return [times](Time, const SE3& T) { return SE3(T.rotation(), times * T.translation()); };
  };
  const CheckResult along = check_poses_of(faster(6));
  EXPECT_EQ(along.trust, Trust::doubtful) << along.measured;
  EXPECT_THAT(along.problem, HasSubstr("vehicles fill the view"));
  EXPECT_EQ(check_poses_of(faster(3.55)).trust, Trust::doubtful) << "28.4 m/s, all else 20.4 m/s: lorries";
  EXPECT_EQ(check_poses_of(faster(-3)).trust, Trust::doubtful) << "all overtakes, 1.33 times as fast";
  EXPECT_EQ(check_poses_of(faster(-2)).trust, Trust::wrong) << "nothing that moves along";
  EXPECT_EQ(check_poses_of(faster(-6)).trust, Trust::doubtful);
  EXPECT_EQ(check_poses_of(faster(20)).trust, Trust::wrong) << "160 m/s";
}

// Under poses T_0v changed by `spoil`.
CheckResult check_poses_in(const test::ToyScene& scene, const std::function<SE3(Time, const SE3&)>& spoil,
                           int scans = kScans) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(scene, scans, folder / "scene");
  const auto dataset = open_dataset(folder / "scene");
  const auto spoilt = std::make_shared<SpoiltTrajectory>(dataset->trajectory(), spoil);
  return check_recording(*dataset, spoilt, 0, dataset->size()).back();
}

CheckResult check_right_poses(const test::ToyScene& scene, int scans = kScans) {
  const auto right = [](Time, const SE3& T) { return T; };
  return check_poses_in(scene, right, scans);
}

// Lorries on both sides of a sensor, slower than it by `slower_mps` and `top_m` higher, and behind them
// nothing but a pole every `poles_m`.
CheckResult check_right_poses_in_a_convoy(double sensor_mps, double slower_mps, double poles_m,
                                          double top_m) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(sensor_mps, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (double x = -45; x <= 75; x += poles_m) scene.world.push_back(test::toy_box({x, 12, 1}, {0.2, 0.2, 3}));
  for (int i = -3; i <= 4; ++i) {
    for (const double side : {-3.5, 3.5}) {
      test::ToyBody lorry = test::toy_box({14.0 * i, side, top_m - 2}, {6, 1.2, 2});
      lorry.velocity_0 = {sensor_mps - slower_mps, 0, 0};
      scene.world.push_back(lorry);
    }
  }
  return check_right_poses(scene);
}

TEST(SelfCheck, ConvoysOfLorriesAreNotRefused) {
  const CheckResult poses = check_right_poses_in_a_convoy(8, 1, 15, 2.5);
  EXPECT_NE(poses.trust, Trust::wrong) << poses.measured << poses.problem;
}

// The poles are seen above them.
TEST(SelfCheck, EdgesOutvoteConvoysOfLorries) {
  EXPECT_EQ(check_right_poses_in_a_convoy(20, 3, 5.3, 0.4).trust, Trust::right);
  for (const double slower_mps : {4.0, 6.0})
    EXPECT_EQ(check_right_poses_in_a_convoy(10, slower_mps, 5.3, 0.4).trust, Trust::right) << slower_mps;
}

// Wagons fill one or both sides of the view at the start, and are left behind later, or gone ahead. There
// their motion stands out; elsewhere the poses do, though a street of bushes is not sharp under them.
TEST(SelfCheck, PosesThatStandOutElsewhereOutvoteVehicles) {
  struct Case {
    double sensor_mps;
    Eigen::Vector3d wagons_0;
    std::vector<double> sides;
    std::vector<double> bushes_m;  // along the way; the slow sensor does not see them behind the wagons
    int scans;
  };
  for (const Case& c :
       {Case{12, {4, 0, 0}, {4}, {36, 48, 53, 62}, 36}, Case{1.2, {8, 0, 0}, {4}, {-5, -1, 2, 7}, 60},
        Case{10, {7.6, 0.55, 0}, {-4, 4}, {36, 42, 51, 60, 70, 78, 85, 94}, 80}}) {
    test::ToyScene scene = test::toy_street("VLP-16");
    scene.trajectory = test::drive(c.sensor_mps, 0);
    scene.world = {test::toy_ground(-1.8)};
    for (const double x : c.bushes_m) scene.world.push_back(test::toy_box({x, 9, 1}, {1, 1, 3}));
    for (const double side : c.sides) {
      for (int i = -3; i <= 2; ++i) {
        test::ToyBody wagon = test::toy_box({3.0 * i, side, 0}, {1, 1, 1.8}, 0.6);
        wagon.velocity_0 = c.wagons_0;
        scene.world.push_back(wagon);
      }
    }
    const CheckResult poses = check_right_poses(scene, c.scans);
    EXPECT_EQ(poses.trust, Trust::right)
        << c.sensor_mps << " beside " << c.wagons_0.x() << " m/s: " << poses.measured << poses.problem;
  }
}

// Signs beside the way tell how fast the sensor is, and not whether it slides.
test::ToyScene street_of_signs(double half_width_m) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(8, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (const double x : {-20.0, -10.0, 14.0, 23.0, 30.0, 41.0})
    scene.world.push_back(test::toy_box({x, -5 - half_width_m, 1}, {0.05, half_width_m, 3}));
  return scene;
}

TEST(SelfCheck, CrossingTrafficContradictsNothing) {
  test::ToyScene scene = street_of_signs(1);
  for (int i = -3; i <= 6; ++i) {
    test::ToyBody wagon = test::toy_box({3.0 * i, 14, 0}, {1, 1, 1.8}, 0.6);
    wagon.velocity_0 = {0, -6, 0};
    scene.world.push_back(wagon);
  }
  const CheckResult poses = check_right_poses(scene);
  EXPECT_EQ(poses.trust, Trust::right) << poses.measured << poses.problem;
}

TEST(SelfCheck, FindsPosesThatSlide) {
  test::ToyScene scene = street_of_signs(8);
  for (int i = -2; i <= 4; ++i)
    for (const double y : {-4.0, 9.0}) scene.world.push_back(test::toy_box({10.0 * i, y, 1}, {1, 0.05, 3}));
  const CheckResult poses = check_poses_in(scene, [](Time t, const SE3& T) {
    return SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, 6 * t.seconds(), 0));
  });
  EXPECT_EQ(poses.trust, Trust::wrong) << poses.measured;
}

TEST(SelfCheck, AWorldOnOneSideContradictsPosesThatNothingSupports) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(4, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (int i = -3; i <= 4; ++i) scene.world.push_back(test::toy_box({3.0 * i, 4, 0}, {1, 1, 1.8}, 0.6));
  const CheckResult poses =
      check_poses_in(scene, [](Time, const SE3& T) { return SE3(T.rotation(), 3 * T.translation()); });
  EXPECT_EQ(poses.trust, Trust::wrong) << poses.measured;
}

// Around a sensor at rest, out of a room whose walls hide them then.
TEST(SelfCheck, ACrowdForAWhileIsOutvoted) {
  test::ToyScene scene = test::toy_room("VLP-16", test::drive(0, 0));
  for (int i = 0; i < 14; ++i) {
    const Eigen::Vector3d outwards = rotation_z(std::numbers::pi * i / 7) * Eigen::Vector3d::UnitX();
    test::ToyBody person = test::toy_box(2.5 * outwards, {0.5, 0.5, 1.8}, std::numbers::pi * i / 7);
    person.velocity_0 = 5 * outwards;
    scene.world.push_back(person);
  }
  EXPECT_EQ(check_right_poses(scene).trust, Trust::doubtful) << "all the time";
  const CheckResult poses = check_right_poses(scene, 4 * kScans);
  EXPECT_EQ(poses.trust, Trust::right) << poses.measured << poses.problem;
}

// Of a sensor that moves between four walls, along its x.
CheckResult check_poses_in_a_room(double speed_mps, const std::function<SE3(Time, const SE3&)>& spoil) {
  return check_poses_in(test::toy_room("VLP-16", test::drive(speed_mps, 0)), spoil);
}

// A registration that finds hardly any motion is not believed: a motorway looks the same from metre to metre.
// But poses under which the scans share nothing are not those of a motorway.
TEST(SelfCheck, DoubtsFastPosesOfASlowSensor) {
  const CheckResult circling = check_poses_in_a_room(1, [](Time t, const SE3&) {
    const double turned = 0.3 * t.seconds();
    return SE3(rotation_z(turned), {60 * std::sin(turned), -60 * std::cos(turned), 0});
  });
  EXPECT_EQ(circling.trust, Trust::doubtful) << circling.measured;
}

// 0.8 m beside the right motion; motions 0.6 m farther off are worse still.
TEST(SelfCheck, DoubtsSlowPosesInReverse) {
  const CheckResult reverse =
      check_poses_in_a_room(0.8, [](Time, const SE3& T) { return SE3(T.rotation(), -T.translation()); });
  EXPECT_GE(reverse.trust, Trust::doubtful) << reverse.measured;
}

// Where they contradict the first of three places all around, as no vehicle does: poses that are at rest, or
// slide, for half a second.
TEST(SelfCheck, RightPosesDoNotOutvoteWrongOnes) {
  for (const Eigen::Vector3d& off_mps : {Eigen::Vector3d(-2, 0, 0), Eigen::Vector3d(0, 2, 0)}) {
    const CheckResult poses = check_poses_in_a_room(2, [&](Time t, const SE3& T) {
      return SE3(T.rotation(), T.translation() + std::min(t.seconds() - 0.5, 0.0) * off_mps);
    });
    EXPECT_EQ(poses.trust, Trust::doubtful) << off_mps.transpose() << ": " << poses.measured;
    EXPECT_THAT(poses.problem, HasSubstr("at 1 of 3 places"));
  }
}

// Planes are those of any speed; the edges of the poles are not.
TEST(SelfCheck, FindsWrongSpeedsBetweenWalls) {
  for (const double speed_mps : {1.5, 15.0}) {  // neighbouring scans tell the higher one alone
    test::ToyScene scene = test::toy_street("VLP-16");
    scene.trajectory = test::drive(speed_mps, 0);
    scene.world = {test::toy_ground(-1.8)};
    for (const double y : {-7.0, 7.0}) scene.world.push_back(test::toy_box({0, y, 1}, {300, 0.2, 4}));
    for (int i = 0; i < 16; ++i) {  // without a period
      const double x = 120 * std::fmod(0.618034 * i * i, 1) - 50;
      scene.world.push_back(test::toy_cylinder({x, i % 2 == 0 ? 4.0 : -4.0, 0}, 0.1, 4));
    }
    EXPECT_EQ(check_right_poses(scene).trust, Trust::right) << speed_mps;
    const CheckResult feet =
        check_poses_in(scene, [](Time, const SE3& T) { return SE3(T.rotation(), T.translation() / 0.3048); });
    EXPECT_EQ(feet.trust, Trust::doubtful) << speed_mps << ": " << feet.measured;
    EXPECT_THAT(feet.problem, HasSubstr("edges"));
    EXPECT_THAT(feet.problem, HasSubstr("positions look like feet"));
  }
}

// Most edges are of the own vehicle. Those of a railing agree where moved by the distance of two posts.
TEST(SelfCheck, EdgesOfTheOwnVehicleContradictNothing) {
  for (const bool railing : {false, true}) {
    test::ToyScene scene = test::toy_street("VLP-16");
    scene.trajectory = test::drive(8, 0);
    scene.world = {test::toy_ground(-1.8)};
    for (const double y : {-7.0, 7.0}) scene.world.push_back(test::toy_box({0, y, 1}, {300, 0.2, 4}));
    for (int i = 0; i < 14; ++i) {
      const Eigen::Vector3d around = rotation_z(0.45 * i) * Eigen::Vector3d(1.5, 0, 0);
      const Eigen::Vector3d in_row(1.2 * (i / 2) - 3.6, i % 2 == 0 ? 1.3 : -1.3, 0);
      test::ToyBody mast = test::toy_cylinder(railing ? in_row : around, 0.05, 1);
      mast.velocity_0 = {8, 0, 0};
      scene.world.push_back(mast);
    }
    const CheckResult poses = check_right_poses(scene);
    EXPECT_EQ(poses.trust, Trust::right) << railing << poses.measured << poses.problem;
  }
}

// All edges move, each another way: they agree nowhere.
TEST(SelfCheck, EdgesThatAgreeNowhereContradictNothing) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(5, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (int i = 0; i < 40; ++i) {
    const Eigen::Matrix3d turn = rotation_z(2.4 * i), heading = rotation_z(1.7 * i);
    test::ToyBody walker = test::toy_cylinder(turn * Eigen::Vector3d(5 + 0.4 * i, 0, 0), 0.1, 1.8);
    walker.velocity_0 = heading * Eigen::Vector3d(3 + 0.1 * i, 0, 0);
    scene.world.push_back(walker);
  }
  const CheckResult poses = check_right_poses(scene);
  EXPECT_EQ(poses.trust, Trust::right) << poses.measured << poses.problem;
}

// The ground looks the same from metre to metre, and what stands beside it is too rough to be compared.
TEST(SelfCheck, DoubtsPosesAtRestInAField) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(25, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (int i = 0; i < 60; ++i) {  // golden ratio, sqrt(2): spread evenly, without a period
    const double x = 80 * std::fmod(0.618034 * i, 1) - 25, y = 5 * std::fmod(1.414214 * i, 1) + 2.5;
    scene.world.push_back(test::toy_box({x, i % 2 == 0 ? y : -y, 0}, {0.3, 0.3, 3}, 1.2 * i));
  }
  const CheckResult poses = check_poses_in(scene, [](Time, const SE3&) { return SE3(); });
  EXPECT_EQ(poses.trust, Trust::doubtful) << poses.measured;
  EXPECT_THAT(poses.problem, HasSubstr("at rest"));
  EXPECT_EQ(check_right_poses(scene).trust, Trust::right);
}

// Nor do the edges of vehicles that move along speak for them.
TEST(SelfCheck, DoubtsPosesAtRestAmongVehicles) {
  test::ToyScene scene = test::toy_street("VLP-16");
  scene.trajectory = test::drive(25, 0);
  scene.world = {test::toy_ground(-1.8)};
  for (int i = 0; i < 60; ++i) {
    const double x = 80 * std::fmod(0.618034 * i, 1) - 25, y = 5 * std::fmod(1.414214 * i, 1) + 4.5;
    scene.world.push_back(test::toy_box({x, i % 2 == 0 ? y : -y, 0}, {0.3, 0.3, 3}, 1.2 * i));
  }
  for (int i = 0; i < 8; ++i) {
    test::ToyBody vehicle = test::toy_cylinder({6.0 * (i / 2) - 9, i % 2 == 0 ? 3.0 : -3.0, 0}, 0.2, 1.8);
    vehicle.velocity_0 = {25, 0, 0};
    scene.world.push_back(vehicle);
  }
  const CheckResult poses = check_poses_in(scene, [](Time, const SE3&) { return SE3(); });
  EXPECT_EQ(poses.trust, Trust::doubtful) << poses.measured;
}

TEST_F(SelfCheckTest, FindsAJump) {
  const CheckResult poses = check_poses_of([](Time t, const SE3& T) {
    return t.seconds() < 0.55 ? T : SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, 3, 0));
  });
  EXPECT_EQ(poses.trust, Trust::doubtful) << poses.measured;
  EXPECT_THAT(poses.problem, HasSubstr("jump"));
}

// One pose that is off alone: the scans half a second before and after the place agree.
TEST_F(SelfCheckTest, FindsAPoseThatIsOffAlone) {
  for (const double off_m : {3.0, 500.0}) {
    const CheckResult poses = check_poses_of([off_m](Time t, const SE3& T) {
      const bool off = t.seconds() > 0.55 && t.seconds() < 0.65;
      return off ? SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, off_m, 0)) : T;
    });
    EXPECT_EQ(poses.trust, Trust::doubtful) << off_m << " m: " << poses.measured;
    EXPECT_THAT(poses.problem, HasSubstr("jump"));
  }
}

// Too little for a peak of its own, and enough that static surfaces move by .2 m in a scan or more.
TEST_F(SelfCheckTest, DoubtsPosesThatAreALittleOff) {
  const CheckResult slow =
      check_poses_of([](Time, const SE3& T) { return SE3(T.rotation(), 0.9 * T.translation()); });
  EXPECT_EQ(slow.trust, Trust::doubtful) << "a tenth too slow: " << slow.measured;
  const CheckResult sideways = check_poses_of([](Time t, const SE3& T) {
    return SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, 0.6 * t.seconds(), 0));
  });
  EXPECT_EQ(sideways.trust, Trust::doubtful) << "sideways by .6 m/s: " << sideways.measured;
  const CheckResult turned = check_poses_of(
      [](Time, const SE3& T) { return T * SE3(rotation_z(std::numbers::pi / 36), Eigen::Vector3d::Zero()); });
  EXPECT_EQ(turned.trust, Trust::doubtful) << "of a body turned by 5 degrees: " << turned.measured;
  const CheckResult nearly =
      check_poses_of([](Time, const SE3& T) { return SE3(T.rotation(), 0.995 * T.translation()); });
  EXPECT_EQ(nearly.trust, Trust::right) << "by .04 m/s: " << nearly.measured << nearly.problem;
}

// However sharp the world is: here all times, of scans and poses, are a thousandth.
TEST_F(SelfCheckTest, FindsPosesThatAreFasterThanAnyVehicle) {
  const CheckResult poses = check_poses_of([](Time t, const SE3& T) {
    return SE3(T.rotation(), T.translation() + Eigen::Vector3d(200 * t.seconds(), 0, 0));
  });
  EXPECT_EQ(poses.trust, Trust::wrong) << poses.measured;
  EXPECT_THAT(poses.problem, HasSubstr("m/s"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
