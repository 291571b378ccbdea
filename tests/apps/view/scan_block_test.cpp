#include "view/scan_block.hpp"

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using namespace app;
using testing::ElementsAre;

// Two lasers; the lower one has two returns, the upper one has one.
LabelledCloud three_points() {
  LidarModel model;
  model.lasers.resize(2);
  LidarScan scan;
  scan.model = std::make_shared<const LidarModel>(model);
  scan.columns = 300;
  scan.input_size = 4;
  const Eigen::Vector3f p(1, 0, 0);
  scan.returns = {{p, 1, 0, 1, 0, 3}, {p, 1, 0, 299, 0, 1}, {p, 1, 0, 2, 1, 0}};
  LabelledCloud cloud;
  cloud.scan = std::make_shared<const LidarScan>(scan);
  cloud.points.points = {{1, 0, 0}, {1, -2, 0}, {1, -2, 0.5F}};
  cloud.labels = {kLabelStatic, kLabelDynamic | 7U << 16U, 0, kLabelDynamic | 7U << 16U};
  cloud.truth = {kLabelDynamic, kLabelDynamic, 0, kLabelStatic};
  cloud.stages = {0, 31, 0, 7};
  cloud.probability = {0.0F, 1.0F, 0.5F, std::numeric_limits<float>::quiet_NaN()};
  return cloud;
}

std::vector<int> values_of(const std::string& bytes) {
  std::vector<int> values;
  for (const char c : bytes) values.push_back(static_cast<unsigned char>(c));
  return values;
}

// One metre is 200 steps of 5 mm; a difference d is coded 2 d where it is not negative, else -2 d - 1.
TEST(ScanBlock, CodesDifferencesLowBytesFirst) {
  const ScanBlock block = encode_scan(three_points(), Eigen::Matrix3d::Identity(), {true, true});
  EXPECT_DOUBLE_EQ(block.step_m, 0.005);
  EXPECT_THAT(values_of(block.bytes),
              ElementsAre(4, 1, 0, 0, 0, 0, 0, 0,                    // returns of laser 0: 2; laser 1: -1
                          400 - 256, 0, 0, 1, 0, 0,                  // x: 200, 0, 0
                          0, 799 - 3 * 256, 0, 0, 3, 0,              // y: 0, -400, 0
                          0, 0, 200, 0, 0, 0,                        // z: 0, 0, 100
                          2, 596 - 2 * 256, 593 - 2 * 256, 0, 2, 2,  // column: 1, 298, -297
                          6, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0,        // record: 3, -2, -1
                          2 + 4, 2 + 8, 1 + 8,                       // label and truth
                          14, 0, 13, 0, 0, 0,                        // object: 7, 0, -7
                          7, 31, 0,                                  // stages
                          255, 254, 0));  // probability of records 3, 1, 0: not known, 1, 0
}

TEST(ScanBlock, CountsPointsAgainstTheTruth) {
  const ScanBlock block = encode_scan(three_points(), Eigen::Matrix3d::Identity(), {true, true});
  EXPECT_EQ(block.points, 3U);
  EXPECT_EQ(block.dynamic, 2U);
  EXPECT_EQ(block.hits, 1U);
  EXPECT_EQ(block.false_positives, 1U);
  EXPECT_EQ(block.missed, 1U);
}

// int16 in steps of 5 mm ends at 163.8 m.
TEST(ScanBlock, TakesACoarserStepForFarPoints) {
  LabelledCloud cloud = three_points();
  cloud.points.points[0] = {0, 0, 1000};
  const ScanBlock block = encode_scan(cloud, Eigen::Matrix3d::Identity(), {});
  EXPECT_GT(block.step_m * 32767, 1000);
  EXPECT_LT(block.step_m, 0.032);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
