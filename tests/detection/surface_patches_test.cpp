#include "detection/surface_patches.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/local_points.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/freespace_votes.hpp>

namespace mapless {
namespace {

using Eigen::Vector3f;

// Between two walls, 6 m ahead and `left_m` to the left, that meet at a right angle.
CompensatedScan corner(double left_m = 6) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("HDL-64E-S3"));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = {test::toy_box({7, 0, 0}, {1, 30, 30}), test::toy_box({0, left_m + 1, 0}, {30, 1, 30})};
  return compensate(test::cast_scan(scene, 0).scan, *scene.trajectory);
}

std::vector<char> all_of(const CompensatedScan& scan) {
  return std::vector<char>(scan.scan->returns.size(), 1);
}

TEST(SurfacePatches, OfAWallLieOnItAndLookAtTheSensor) {
  const CompensatedScan scan = corner();
  const LocalPoints points = test::local_points(scan);
  const SurfacePatches patches(*scan.scan, points, all_of(scan));
  std::size_t planes = 0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const Vector3f& c = patches[p].centre;
    if (!patches[p].is_plane || c.norm() > 12 || std::abs(c.x() - c.y()) < 1) continue;
    ++planes;
    const bool ahead = c.x() > c.y();
    EXPECT_NEAR(ahead ? c.x() : c.y(), 6, 1e-3);
    EXPECT_LT((patches[p].normal - (ahead ? Vector3f(-1, 0, 0) : Vector3f(0, -1, 0))).norm(), 1e-3);
    EXPECT_LT(patches[p].thickness_m, 1e-3);
  }
  EXPECT_GT(planes, 300u);
}

// Legs of 0.2 m or more: 5 cm from the plane between them, as a standard deviation. Where in a patch the
// walls meet depends on how far off they are.
TEST(SurfacePatches, WhereTwoWallsMeetAreNoPlanes) {
  std::size_t mixed = 0;
  for (const double left_m : {6.0, 6.15, 6.3, 6.45, 6.6}) {
    SCOPED_TRACE(testing::Message() << "to the left: " << left_m << " m");
    const CompensatedScan scan = corner(left_m);
    const LocalPoints points = test::local_points(scan);
    const SurfacePatches patches(*scan.scan, points, all_of(scan));
    for (std::size_t p = 0; p < patches.size(); ++p) {
      const auto members = patches.members(p);
      const auto ahead = std::count_if(members.begin(), members.end(), [&](std::int32_t i) {
        return points.points[static_cast<std::size_t>(i)].y() < static_cast<float>(left_m) - 0.005F;
      });
      if (std::abs(static_cast<double>(members.size()) / 2 - static_cast<double>(ahead)) > 4) continue;
      if (members.size() < 48 || patches[p].centre.norm() > 10) continue;
      ++mixed;
      EXPECT_FALSE(patches[p].is_plane) << patches[p].thickness_m;
    }
  }
  EXPECT_GT(mixed, 3u);
}

TEST(SurfacePatches, HaveEveryWantedReturnOnce) {
  const CompensatedScan scan = corner();
  std::vector<char> wanted = all_of(scan);
  for (std::size_t i = 0; i < wanted.size(); i += 3) wanted[i] = 0;
  const SurfacePatches patches(*scan.scan, test::local_points(scan), wanted);
  std::vector<char> seen(wanted.size(), 0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (const std::int32_t i : patches.members(p)) ++seen[static_cast<std::size_t>(i)];
  }
  EXPECT_EQ(seen, wanted);
}

// Rows end at the lowest and the highest laser, columns go round.
TEST(SurfacePatches, AreBesideEightOthersOrFive) {
  const CompensatedScan scan = corner();
  const SurfacePatches patches(*scan.scan, test::local_points(scan), all_of(scan));
  const auto across = patches.size() / (64 / kPatchRows);
  const auto beside = [&](std::size_t p) {
    std::vector<std::size_t> out;
    patches.for_each_beside(p, [&](std::size_t other) { out.push_back(other); });
    return out;
  };
  EXPECT_EQ(beside(0), (std::vector<std::size_t>{across - 1, 1, 2 * across - 1, across, across + 1}));
  EXPECT_EQ(beside(across + 1), (std::vector<std::size_t>{0, 1, 2, across, across + 2, 2 * across,
                                                          2 * across + 1, 2 * across + 2}));
  EXPECT_EQ(beside(patches.size() - 1).size(), 5u);
}

}  // namespace
}  // namespace mapless
