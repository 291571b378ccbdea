#include "detection/freespace/range_noise.hpp"

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

LidarScan with_noise(test::ToyScene scene, double noise_m) {
  scene.range_noise_m = noise_m;
  return *test::cast_scan(scene, 3).scan;
}

TEST(RangeNoise, IsThatOfTheRangesOrALittleLess) {
  for (const char* sensor : {"HDL-64E-S2", "VLP-16", "OS1-128"}) {
    for (const auto& scene : {test::toy_room(sensor, test::drive(2, 0.5)), test::toy_street(sensor)}) {
      for (const double noise_m : {0.01, 0.02, 0.05, 0.1}) {
        SCOPED_TRACE(testing::Message() << sensor << " with " << noise_m);
        const double found_m = range_noise_m(with_noise(scene, noise_m));
        EXPECT_GT(found_m, 0.7 * noise_m);
        EXPECT_LT(found_m, 1.05 * noise_m);
      }
      EXPECT_LT(range_noise_m(with_noise(scene, 0)), 0.005);
    }
  }
}

TEST(RangeNoise, OfFewReturnsIsUnknown) {
  test::ToyScene scene = test::toy_room("VLP-16", test::drive(0, 0));
  scene.range_noise_m = 0.05;
  LidarScan scan = *test::cast_scan(scene, 0).scan;
  scan.returns.resize(15);
  EXPECT_EQ(range_noise_m(scan), 0);
  scan.returns.clear();
  EXPECT_EQ(range_noise_m(scan), 0);
}

TEST(RangeNoise, ToleranceIsThatOfTheParametersOrFourDeviations) {
  const test::ToyScene street = test::toy_street("HDL-64E-S2");
  VotingParameters parameters;
  EXPECT_NEAR(with_tolerance_for_noise(parameters, with_noise(street, 0.02)).tolerance_m,
              parameters.tolerance_m, 0.005);
  const double tolerance_m = with_tolerance_for_noise(parameters, with_noise(street, 0.05)).tolerance_m;
  EXPECT_GT(tolerance_m, 0.14);
  EXPECT_LT(tolerance_m, 0.21);
  parameters.tolerance_m = 0.5;
  EXPECT_EQ(with_tolerance_for_noise(parameters, with_noise(street, 0.05)).tolerance_m, 0.5);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
