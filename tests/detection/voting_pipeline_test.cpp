#include <memory>

#include <gtest/gtest.h>

#include "detection/detection_pipeline.hpp"
#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// Over all scans so far, at most five. However far apart the reference scans are.
TEST(VotingPipeline, GivesTheVelocityOfTheSensor) {
  const auto scene = test::with_columns(test::toy_room("VLP-16", test::drive(2, 0)), 100);
  DetectorParameters parameters;
  for (const int first_gap : {1, 8}) {
    SCOPED_TRACE(first_gap);
    parameters.voting.first_gap = first_gap;
    const auto pipeline = make_voting_pipeline(parameters);
    for (int k = 0; k < 8; ++k) pipeline->add(test::cast_scan(scene, k).scan, *scene.trajectory);
    for (std::size_t k = 0; k < 7; ++k) {
      const Eigen::Vector3d expected{k == 0 ? 0.0 : 2.0, 0, 0};
      EXPECT_LT((pipeline->propose(k).sensor_velocity_0 - expected).norm(), 1e-6) << k;
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
