#include "detection/evidence/surface_planes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "detection/evidence/collect_evidence.hpp"
#include "support/detection/standing_scene.hpp"
#include "support/local_points.hpp"
#include "support/small_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3f;
using test::cast;
using test::local_points;
using test::standing;
using test::wall_at;

constexpr float kTolerance_m = 0.08F;

// The plane of a wall ahead goes on for kReach_m from a point; half of the tolerance off it is too far.
TEST(SurfacePlanes, ContainTheWallAroundAPoint) {
  const CompensatedScan scan = cast(standing({wall_at(7)}, "OS1-128"));
  const LocalPoints points = local_points(scan);
  const SurfacePlanes planes(*scan.scan, points.points, kTolerance_m);
  int ahead = 0;
  for (std::size_t i = 0; i < points.points.size(); i += 13) {
    const Vector3f& p = points.points[i];
    if (p.x() < 0 || std::abs(p.y()) > 1 || std::abs(p.z()) > 1) continue;
    ++ahead;
    EXPECT_TRUE(planes.contains(i, p + Vector3f(0, 0.7F, -0.6F)));
    EXPECT_TRUE(planes.contains(i, p + Vector3f(0.03F, 0.5F, 0)));
    EXPECT_FALSE(planes.contains(i, p + Vector3f(0.05F, 0.5F, 0)));
    EXPECT_FALSE(planes.contains(i, p + Vector3f(-0.05F, 0.5F, 0)));
    EXPECT_FALSE(planes.contains(i, p + Vector3f(0, 0.8F, -0.7F)));
  }
  EXPECT_GT(ahead, 50);
}

// On a post of 30 cm radius the points within .4 m of its middle are up to 30 cm off any plane, and those of
// a single laser are no surface.
TEST(SurfacePlanes, APostHasNoneNorHasALineOfPoints) {
  const CompensatedScan post = cast(standing({test::toy_cylinder({4, 0, 0}, 0.3, 3)}, "OS1-128"));
  const LocalPoints of_post = local_points(post);
  const SurfacePlanes planes(*post.scan, of_post.points, kTolerance_m);
  int middle = 0;
  for (std::size_t i = 0; i < of_post.points.size(); ++i) {
    if (std::abs(of_post.points[i].y()) > 0.1F || std::abs(of_post.points[i].z()) > 1) continue;
    ++middle;
    EXPECT_FALSE(planes.contains(i, of_post.points[i]));
  }
  EXPECT_GT(middle, 50);

  const LidarScan line = test::small_scan({0});
  std::vector<Vector3f> straight;
  for (std::size_t i = 0; i < line.returns.size(); ++i)
    straight.emplace_back(5.0F + 0.02F * static_cast<float>(i % 2), 0.02F * static_cast<float>(i), 0.0F);
  EXPECT_FALSE(SurfacePlanes(line, straight, kTolerance_m).contains(12, straight[12]));
}

// Ground that was seen 3 cm lower before: 12 m away its rays make 8 degrees with it, and ended .2 m behind,
// out of the tolerance of .08 m. It was there all the time.
TEST(SurfacePlanes, GroundAtASmallAngleWasSeenByRaysThatEndBehind) {
  const auto ground = [](double z) { return cast(standing({test::toy_ground(z)}, "OS1-128")); };
  const CompensatedScan query = ground(-1.73);
  const RayImage before(ground(-1.76));
  const auto votes =
      collect_evidence(*query.scan, local_points(query), {{&before, 4}}, RayImage(query), VotingParameters{});
  int far = 0, seen = 0, through = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const double away_m = query.points_0[i].head<2>().norm();
    if (away_m < 6.5 || away_m > 8) continue;
    ++far;
    seen += votes[i].past == -2 ? 1 : 0;
    through += votes[i].past > 0 ? 1 : 0;
  }
  EXPECT_GT(seen, far / 3);
  EXPECT_EQ(through, 0) << "of " << far;
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
