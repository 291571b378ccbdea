#include "detection/tracking/slow_motion.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

// Offsets of planes that move with a velocity: a plane was `before_s * velocity` back, as seen by rays that
// ended on it then.
std::vector<PlaneOffset> offsets_of(const std::vector<Vector3d>& normals, const Vector3d& velocity_0) {
  std::vector<PlaneOffset> offsets;
  for (const Vector3d& normal : normals) {
    for (const double before_s : {-0.1, 0.1, 0.2}) {
      for (int k = 0; k < 20; ++k) offsets.push_back({normal, -before_s * normal.dot(velocity_0), before_s});
    }
  }
  return offsets;
}

const std::vector<Vector3d> kCorner = {Vector3d(1, 0, 0), Vector3d(0, 0.6, 0.8), Vector3d(0, -0.8, 0.6)};

TEST(SlowMotion, PlanesOfACornerGiveTheirVelocity) {
  for (const Vector3d& v : {Vector3d(0, 0, 0), Vector3d(0.3, 0, 0), Vector3d(-0.1, 0.2, 0.05)}) {
    const SlowMotion motion = slow_motion(offsets_of(kCorner, v));
    EXPECT_LT((motion.velocity_0 - v).norm(), 1e-3);
    // Per direction 20 (0.1^2 + 0.1^2 + 0.2^2) / 0.03^2 = 1333, .97 of which counts.
    EXPECT_NEAR(motion.std_mps, 1 / std::sqrt(0.97 * 1333), 2e-4);
  }
}

TEST(SlowMotion, AWallDoesNotShowHowItSlides) {
  EXPECT_GT(slow_motion(offsets_of({Vector3d(1, 0, 0)}, {0, 2, 0})).std_mps, 10);
  EXPECT_GT(slow_motion(offsets_of({Vector3d(1, 0, 0), Vector3d(0, 1, 0)}, {0, 2, 0})).std_mps, 10);
  EXPECT_GT(slow_motion({}).std_mps, 10);
}

// A tenth of the rays ended on something 0.25 m behind.
TEST(SlowMotion, RaysOnSomethingElseHardlyCount) {
  const Vector3d v(0.1, -0.1, 0.1);
  auto offsets = offsets_of(kCorner, v);
  for (std::size_t k = 0; k < offsets.size(); k += 10) offsets[k].off_m = 0.25;
  EXPECT_LT((slow_motion(offsets).velocity_0 - v).norm(), 0.03);
}

// Of a ball they point away from its centre, whatever the noise of the ranges.
TEST(SurfaceNormals, OfABallPointAwayFromItsCentre) {
  test::ToyScene scene;
  const Vector3d centre(3, 0, 0);
  scene.model = std::make_shared<const LidarModel>(named_model("OS1-128"));
  scene.trajectory = test::drive(0, 0);
  scene.world = {test::toy_sphere(centre, 0.6)};
  scene.range_noise_m = 0.01;
  auto [compensated, points] = compensate_locally(test::cast_scan(scene, 0).scan, *scene.trajectory);
  const SurfaceNormals normals(*compensated.scan, points.points);
  int known = 0, right = 0;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const Vector3d normal = normals.of(i);
    const Vector3d outwards = points.origin_0 + points.points[i].cast<double>() - centre;
    if (normal.isZero(0)) continue;
    ++known;
    right += std::abs(normal.dot(outwards.normalized())) > std::cos(0.26) ? 1 : 0;  // 15 degrees
  }
  EXPECT_GT(known, 1000);
  EXPECT_GT(right, 0.9 * known);
}

// The wall behind a thin post is beyond its edges.
TEST(SurfaceNormals, AThinPostHasNone) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("OS1-128"));
  scene.trajectory = test::drive(0, 0);
  scene.world = {test::toy_cylinder({3, 0, 0}, 0.02, 3), test::toy_box({8, 0, 0}, {0.5, 9, 9})};
  auto [compensated, points] = compensate_locally(test::cast_scan(scene, 0).scan, *scene.trajectory);
  const SurfaceNormals normals(*compensated.scan, points.points);
  int on_post = 0;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    if (compensated.scan->returns[i].range_m > 5) continue;
    ++on_post;
    EXPECT_TRUE(normals.of(i).isZero(0));
  }
  EXPECT_GT(on_post, 50);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
