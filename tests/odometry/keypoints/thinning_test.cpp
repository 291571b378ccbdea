#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "odometry/keypoints/keypoints.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// Ranges of a scan: most of the ground near the sensor, few far off.
std::vector<float> ranges_of(unsigned seed, std::size_t number) {
  std::mt19937 random(seed);
  std::lognormal_distribution<float> range(2.2F, 0.7F);
  std::vector<float> out(number);
  for (float& r : out) r = std::clamp(range(random), 1.5F, 90.0F);
  return out;
}

LidarScan scan_of(const std::vector<float>& ranges) {
  LidarScan scan;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto angle = static_cast<float>(i) * 0.01F;
    const Eigen::Vector3f direction(std::cos(angle), std::sin(angle), 0);
    scan.returns.push_back({ranges[i] * direction, ranges[i], 0, 0, static_cast<std::int32_t>(i % 64),
                            static_cast<std::uint32_t>(i)});
  }
  return scan;
}

double sum_of_shares(const std::vector<float>& squares, double r2) {
  double out = 0;
  for (const float square : squares) out += std::min(1.0, square / r2);
  return out;
}

TEST(Thinning, ByHand) {
  EXPECT_DOUBLE_EQ(full_density_square({9, 1, 4}, 2), 5);     // 1/5 + 4/5 + 1
  EXPECT_DOUBLE_EQ(full_density_square({9, 1, 4}, 2.25), 4);  // 1/4 + 1 + 1
  EXPECT_DOUBLE_EQ(full_density_square({9, 1, 4}, 0.5), 28);  // 1/28 + 4/28 + 9/28
  EXPECT_DOUBLE_EQ(full_density_square({4, 4, 4, 4}, 2), 8);
}

TEST(Thinning, ShareOfEveryReturnSumsToTheTarget) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::vector<float> squares = ranges_of(seed, 200 + 11 * seed);
    for (float& square : squares) square *= square;
    const double target = static_cast<double>(squares.size()) * (0.5 + seed) / 100.5;
    EXPECT_NEAR(sum_of_shares(squares, full_density_square(squares, target)), target, 1e-6 * target);
  }
}

// The definition gives the expected count. Its error has two parts: the random choice (standard deviation
// below 110), and the distribution of ranges, estimated from a thousandth of the returns to 4 %.
TEST(Thinning, KeepsAboutTheNumberWanted) {
  for (const int wanted : {2000, 16000, 40000}) {
    for (unsigned seed = 0; seed < 5; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", wanted " << wanted);
      OdometryParameters parameters;
      parameters.max_scan_points = wanted;
      const auto kept = static_cast<double>(thin(scan_of(ranges_of(seed, 110000)), parameters).size());
      EXPECT_NEAR(kept, wanted, 0.12 * wanted);
    }
  }
}

TEST(Thinning, KeepsTheOrderOfTheReturns) {
  const auto points = thin(scan_of(ranges_of(2, 50000)), {});
  EXPECT_LT(points.size(), 20000u);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](const ScanPoint& a, const ScanPoint& b) {
    return a.return_index < b.return_index;
  }));
}

// For any size, 400 consecutive elements include some of every tenth of the scan.
TEST(Thinning, PassOrderIsAPermutationThatCoversTheScan) {
  for (const std::size_t size : {3000u, 3017u, 16000u}) {
    SCOPED_TRACE(size);
    const std::vector<std::uint32_t> order = pass_order(size);
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(sorted[i], i);
    for (std::size_t first = 0; first + 400 <= size; first += 400) {
      std::array<int, 10> of_tenth{};
      for (std::size_t i = first; i < first + 400; ++i) ++of_tenth[order[i] * 10 / size];
      EXPECT_GT(*std::min_element(of_tenth.begin(), of_tenth.end()), 0);
    }
  }
  EXPECT_TRUE(pass_order(0).empty());
}

TEST(Thinning, KeepsAllOfFew) { EXPECT_EQ(thin(scan_of(ranges_of(1, 9000)), {}).size(), 9000); }

// One point in every cube of 0.1875 m that touches a wall of 3 m by 3 m: 256 of them, in 64, 16 and 4 cubes
// twice, four and eight times as large.
TEST(Keypoints, CubesAreHalvedUntilThereAreEnough) {
  std::vector<ScanPoint> wall;
  for (int i = 0; i < 256; ++i) {
    const auto across = static_cast<float>(i % 16), up = static_cast<float>(i / 16);
    wall.push_back(
        {0.1875F * Eigen::Vector3f(across + 0.5F, 20.5F, up + 0.5F), 5, i, 0, static_cast<std::uint32_t>(i)});
  }
  OdometryParameters parameters;
  const auto keypoints = [&](int fewest, int halvings) {
    parameters.min_keypoints = fewest;
    return select_keypoints(wall, parameters, halvings).size();
  };
  EXPECT_EQ(keypoints(4, 2), 4);
  EXPECT_EQ(keypoints(5, 2), 16);
  EXPECT_EQ(keypoints(200, 2), 64);
  EXPECT_EQ(keypoints(200, 3), 256);
}

// 100,000 returns at 3 m and 10,000 at 6 m, of which 12,000 are wanted: 900,000 / r^2 + 360,000 / r^2 =
// 12,000, so that r^2 is 105, and 9 / 105 and 36 / 105 of them are kept.
TEST(Thinning, ThinsByTheSquareOfTheRange) {
  std::vector<float> ranges(110000, 3);
  for (std::size_t i = 0; i < ranges.size(); i += 11) ranges[i] = 6;
  int near = 0, far = 0;
  OdometryParameters parameters;
  parameters.max_scan_points = 12000;
  for (const ScanPoint& p : thin(scan_of(ranges), parameters)) ++(p.range_m < 4 ? near : far);
  EXPECT_NEAR(near, 8571, 400);
  EXPECT_NEAR(far, 3429, 200);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
