#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "detection/evidence/evidence_collector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

// Walls ahead, x, of a sensor at rest, as the tests of votes want them.
namespace mapless::test {

/// Its front is at x [m], and it is wide and high enough to hide all that is behind.
inline ToyBody wall_at(double x) { return toy_box({x + 0.5, 0, 0}, {0.5, 40, 40}); }

inline ToyScene standing(const ToyWorld& world, const char* sensor = "HDL-64E-S3") {
  ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = std::make_shared<StationaryTrajectory>();
  scene.world = world;
  return scene;
}

inline CompensatedScan cast(const ToyScene& scene, int number = 0) {
  return compensate(cast_scan(scene, number).scan, *scene.trajectory);
}

/// Points well within all the walls, as no wall reaches round the sensor.
inline bool is_ahead(const CompensatedScan& scan, std::size_t i) {
  const Eigen::Vector3d& p = scan.points_0[i];
  return std::abs(p.y()) < 0.5 * p.x();
}

inline std::vector<ReferenceScan> references(const std::vector<RayImage>& images,
                                             const std::vector<int>& gaps) {
  std::vector<ReferenceScan> all;
  for (std::size_t k = 0; k < images.size(); ++k) all.push_back({&images[k], gaps[k]});
  return all;
}

}  // namespace mapless::test
