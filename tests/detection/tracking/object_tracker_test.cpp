#include "detection/tracking/object_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;
using test::ToyBody;
using test::ToyScene;

constexpr double kScan_s = 0.1;

ToyScene scene_of(std::vector<ToyBody> bodies, double sensor_speed = 0) {
  ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("OS1-64"));
  scene.trajectory = test::drive(sensor_speed, 0);
  scene.range_noise_m = 0.02;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].object = static_cast<std::uint16_t>(i + 1);
    scene.world.push_back(bodies[i]);
  }
  return scene;
}

ToyBody moving(ToyBody body, const Vector3d& velocity) {
  body.velocity_0 = velocity;
  return body;
}

// The detection of ground truth: the points of each moving body as one object.
Detection true_detection(const ToyScene& scene, int number) {
  const test::ToyScan toy = test::cast_scan(scene, number);
  Detection detection;
  detection.scan = toy.scan;
  detection.sequence_number = static_cast<std::size_t>(number);
  for (const LidarReturn& r : toy.scan->returns)
    detection.object.push_back(static_cast<std::uint16_t>(toy.labels[r.input_index] >> 16));
  detection.objects = static_cast<int>(scene.world.size());
  return detection;
}

std::vector<TrackedObject> process(ObjectTracker& tracker, const Detection& detection,
                                   const Trajectory& trajectory) {
  return tracker.process(detection, trajectory,
                         std::make_shared<const RayImage>(compensate(detection.scan, trajectory)));
}

std::vector<TrackedObject> track(ObjectTracker& tracker, const ToyScene& scene, int first, int count) {
  std::vector<TrackedObject> objects;
  for (int k = first; k < first + count; ++k)
    objects = process(tracker, true_detection(scene, k), *scene.trajectory);
  return objects;
}

double longest_std(const TrackedObject& object) { return object.velocity_std_0().maxCoeff(); }

TEST(ObjectTracker, EstimatesVelocityAndItsUncertainty) {
  double normalised = 0;
  constexpr int kSeeds = 8;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const Vector3d velocity(8 * uniform(random), 8 * uniform(random), uniform(random));
    const ToyBody car =
        test::toy_box(Vector3d(8, 7, 0) - 0.5 * velocity, {2.2, 0.9, 0.75}, 3 * uniform(random));
    ToyScene scene = scene_of({moving(car, velocity)}, 5 + 5 * uniform(random));
    scene.seed = seed;
    // The world may lie any way round.
    const SE3 T_0w(so3_exp(Vector3d(uniform(random), uniform(random), uniform(random))), {30, -20, 7});
    ObjectTracker tracker;
    std::vector<TrackedObject> objects;
    const test::MovedTrajectory trajectory(scene.trajectory, T_0w, Duration());
    for (int k = 0; k < 9; ++k) objects = process(tracker, true_detection(scene, k), trajectory);
    ASSERT_EQ(objects.size(), 1u);
    const Vector3d error = objects[0].velocity_0 - T_0w.rotation().transpose() * velocity;
    EXPECT_LT(error.norm(), 0.5) << error.transpose();
    EXPECT_LT(longest_std(objects[0]), 0.6);
    EXPECT_EQ(objects[0].age, 9);
    normalised += error.cwiseQuotient(objects[0].velocity_std_0()).squaredNorm() / 3 / kSeeds;
  }
  EXPECT_LT(normalised, 3) << "errors are much larger than said";
}

TEST(ObjectTracker, ReportsCentreExtentAndTimeOfTheMeanPoint) {
  const ToyBody ball = moving(test::toy_sphere({6, 0, 0}, 0.5), {0, 3, 0});
  const ToyScene scene = scene_of({ball});
  ObjectTracker tracker;
  const std::vector<TrackedObject> objects = track(tracker, scene, 0, 5);
  ASSERT_EQ(objects.size(), 1u);
  const TrackedObject& o = objects[0];
  const Vector3d centre = ball.T_0b.translation() + o.time.seconds() * ball.velocity_0;
  // Seen from x = 0: the near half of the ball, of the full width, 0.5 m deep.
  EXPECT_NEAR(o.centre_0.y(), centre.y(), 0.05);
  EXPECT_NEAR(o.centre_0.z(), centre.z(), 0.05);
  EXPECT_NEAR(o.centre_0.x(), centre.x() - 0.25, 0.1);
  EXPECT_NEAR(o.extent_0.y(), 1, 0.1);
  EXPECT_NEAR(o.extent_0.x(), 0.5, 0.15);
  EXPECT_GT(o.points, 100);
}

// A wall without a visible end looks the same wherever along itself it is.
TEST(ObjectTracker, AWallHasALargeStandardDeviationAlongItself) {
  const ToyScene scene = scene_of({moving(test::toy_box({0, 6, 0}, {300, 0.5, 60}), {7, 0, 0})});
  ObjectTracker tracker;
  const std::vector<TrackedObject> objects = track(tracker, scene, 0, 6);
  ASSERT_EQ(objects.size(), 1u);
  const Vector3d std = objects[0].velocity_std_0();
  EXPECT_LT(std.y(), 0.4);
  EXPECT_GT(std.x(), 3);
  EXPECT_GT(std.z(), 3);
  EXPECT_LT(std::abs(objects[0].velocity_0.y()), 0.5);
}

// A bus comes out from behind a house: its visible part grows at the front alone, and the centre of that part
// moves at half its speed.
TEST(ObjectTracker, AGrowingVisiblePartDoesNotBiasTheVelocity) {
  ToyScene scene = scene_of({moving(test::toy_box({-7, 9, 0}, {5, 1.2, 1.4}), {8, 0, 0})});
  scene.world.push_back(test::toy_box({-12, 5, 0}, {8, 0.2, 3}));
  ObjectTracker tracker;
  track(tracker, scene, 3, 4);
  const std::vector<TrackedObject> objects = track(tracker, scene, 7, 4);
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_NEAR(objects[0].velocity_0.x(), 8, 0.8);
  EXPECT_NEAR(objects[0].velocity_0.y(), 0, 0.4);
}

TEST(ObjectTracker, CrossingObjectsKeepTheirIds) {
  const ToyScene scene = scene_of({moving(test::toy_cylinder({8, -1.6, 0}, 0.3, 0.9), {0, 1.5, 0}),
                                   moving(test::toy_cylinder({9, 1.6, 0}, 0.3, 0.9), {0, -1.5, 0})});
  ObjectTracker tracker;
  const auto before = track(tracker, scene, 0, 4);
  ASSERT_EQ(before.size(), 2u);
  track(tracker, scene, 4, 14);
  const auto after = track(tracker, scene, 18, 4);
  ASSERT_EQ(after.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(after[i].id, before[i].id);
    EXPECT_EQ(after[i].number, i + 1);
    EXPECT_NEAR(after[i].velocity_0.y(), i == 0 ? 1.5 : -1.5, 0.4);
  }
}

// Two objects are detected as one while they are close.
TEST(ObjectTracker, ObjectsThatMergeAndSplitGetTheirIdsBack) {
  const ToyScene scene = scene_of({moving(test::toy_cylinder({8, -1.2, 0}, 0.3, 0.9), {0, 1, 0}),
                                   moving(test::toy_cylinder({8, 1.2, 0}, 0.3, 0.5), {0, -1, 0})});
  ObjectTracker tracker;
  const auto before = track(tracker, scene, 0, 8);
  for (int k = 8; k < 12; ++k) {
    Detection merged = true_detection(scene, k);
    for (std::uint16_t& number : merged.object) number = number == 0 ? 0 : 1;
    const auto objects = process(tracker, merged, *scene.trajectory);
    ASSERT_EQ(objects.size(), 1u);
    EXPECT_EQ(objects[0].id, before[0].id) << "the larger keeps its id";
  }
  ToyScene apart = scene;  // they turned back
  for (ToyBody& body : apart.world) {
    body.T_0b = SE3(body.T_0b.rotation(), body.T_0b.translation() + 2.3 * body.velocity_0);
    body.velocity_0 = -body.velocity_0;
  }
  const auto after = track(tracker, apart, 12, 4);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].id, before[0].id);
  EXPECT_EQ(after[1].id, before[1].id);
}

TEST(ObjectTracker, APartThatSplitsOffIsNewAndStartsWithTheVelocityOfTheWhole) {
  const ToyScene scene = scene_of({moving(test::toy_box({9, -2, 0}, {0.9, 2.2, 0.75}), {0, 5, 0})});
  ObjectTracker tracker;
  const auto whole = track(tracker, scene, 0, 6);
  Detection split = true_detection(scene, 6);
  const double y = whole[0].centre_0.y() + 0.5 + 1;  // a quarter of it is beyond
  for (std::size_t i = 0; i < split.object.size(); ++i) {
    if (split.object[i] != 0 && static_cast<double>(split.scan->returns[i].position_v.y()) > y)
      split.object[i] = 2;
  }
  const auto parts = process(tracker, split, *scene.trajectory);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].id, whole[0].id);
  EXPECT_EQ(parts[0].age, 7);
  EXPECT_GT(parts[1].id, whole[0].id);
  EXPECT_EQ(parts[1].age, 1);
  EXPECT_NEAR(parts[1].velocity_0.y(), 5, 1);
}

TEST(ObjectTracker, AnObjectSeenAgainWithinASecondKeepsItsId) {
  const ToyScene scene = scene_of({moving(test::toy_box({9, -2, 0}, {0.9, 2.2, 0.75}), {0, 2, 0})});
  ToyScene hidden = scene;
  hidden.world[0].T_0b = SE3(Eigen::Matrix3d::Identity(), {0, 0, 500});
  ObjectTracker tracker;
  const auto before = track(tracker, scene, 0, 4);
  EXPECT_TRUE(track(tracker, hidden, 4, 5).empty());
  const auto back = track(tracker, scene, 9, 1);
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].id, before[0].id);
  EXPECT_EQ(back[0].age, 10);
  track(tracker, hidden, 10, 12);
  const auto later = track(tracker, scene, 22, 1);
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].id, before[0].id + 1) << "unseen for longer than a second";
  EXPECT_EQ(later[0].age, 1);
  EXPECT_NEAR(longest_std(later[0]), 15, 1e-9) << "nothing is known of its velocity";
}

// From 8 to 2 m/s at 3 m/s^2, then on.
TEST(ObjectTracker, FollowsABrakingCar) {
  ToyScene scene = scene_of({test::toy_box({0, 0, 0}, {2.2, 0.9, 0.75})}, 4);
  ObjectTracker tracker;
  double speed = 8;
  Vector3d place(6, 5, 0);
  TrackedObject last;
  for (int k = 0; k < 45; ++k) {
    const double middle_s = (k + 0.5) * kScan_s;
    if (k >= 10) speed = std::max(2.0, speed - 3 * kScan_s);
    place.x() += speed * kScan_s;
    scene.world[0].velocity_0 = {speed, 0, 0};
    scene.world[0].T_0b = SE3(Eigen::Matrix3d::Identity(), place - middle_s * scene.world[0].velocity_0);
    const auto objects = process(tracker, true_detection(scene, k), *scene.trajectory);
    ASSERT_EQ(objects.size(), 1u);
    last = objects[0];
    EXPECT_EQ(last.id, 1u);
    if (k <= 3) continue;
    EXPECT_NEAR(last.velocity_0.x(), speed, 1.2) << "scan " << k;
  }
  EXPECT_NEAR(last.velocity_0.x(), 2, 0.4);
}

TEST(ObjectTracker, AcceptsScansWithoutObjects) {
  const ToyScene scene = scene_of({test::toy_box({9, 0, 0}, {1, 1, 1})});  // stands
  ObjectTracker tracker;
  EXPECT_TRUE(track(tracker, scene, 0, 3).empty());
}

TEST(ObjectTracker, RefusesScansOutOfOrderAndCompensatedOnes) {
  const ToyScene scene = scene_of({moving(test::toy_box({9, -2, 0}, {0.9, 2.2, 0.75}), {0, 2, 0})});
  ObjectTracker tracker;
  track(tracker, scene, 3, 1);
  EXPECT_THROW(track(tracker, scene, 3, 1), InputError);
  EXPECT_THROW(track(tracker, scene, 2, 1), InputError);
  Detection compensated = true_detection(scene, 4);
  auto scan = std::make_shared<LidarScan>(*compensated.scan);
  scan->compensated_to = scan->start;
  compensated.scan = scan;
  EXPECT_THROW(tracker.process(compensated, *scene.trajectory, nullptr), InputError);
  EXPECT_EQ(track(tracker, scene, 4, 1).at(0).age, 2) << "as it was before the calls";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
