#include "detection/freespace/ray_image.hpp"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "support/detection/standing_scene.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

TEST(RayImage, SharesBeamsWithAnImageOfTheSameSensorAlone) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = {test::wall_at(10)};
  const CompensatedScan compensated = compensate(test::cast_scan(scene, 0).scan, *scene.trajectory);
  const RayImage before(compensated), after(compensated, &before);
  EXPECT_EQ(&before.fan(), &after.fan());
  for (int column = 0; column < before.columns(); ++column)
    ASSERT_EQ(before.pose(column).T_h0, after.pose(column).T_h0);
  scene.model = std::make_shared<const LidarModel>(named_model("OS1-64"));
  const RayImage other(compensate(test::cast_scan(scene, 0).scan, *scene.trajectory), &before);
  EXPECT_NE(&before.fan(), &other.fan());
  EXPECT_EQ(other.fan().beams.size(), 64u);
}

// The hub's x axis at a column is the x axis of its frame there.
TEST(RayImage, PosesTurnWithTheHub) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("VLP-16"));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = {test::wall_at(10)};
  const RayImage image(compensate(test::cast_scan(scene, 0).scan, *scene.trajectory));
  for (int column = 0; column < image.columns(); column += 97) {
    const double angle = scene.model->hub_angle(column);
    const Eigen::Vector3f ahead(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0);
    EXPECT_LT((image.pose(column) * ahead - Eigen::Vector3f::UnitX()).norm(), 1e-6F);
    EXPECT_LT((image.pose(column) * Eigen::Vector3f::UnitZ() - Eigen::Vector3f::UnitZ()).norm(), 1e-6F);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
