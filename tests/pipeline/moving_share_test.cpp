#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/pipeline/online_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

// The same number of points in each of the first `sectors` sectors.
MovingShare::Sectors evenly(std::size_t points, std::size_t sectors = MovingShare::kSectors) {
  MovingShare::Sectors out{};
  std::fill_n(out.begin(), sectors, points / sectors);
  return out;
}

// Of 16,000 points a scan, these per cent move, all in the first `sectors` sectors.
MovingShare share_of(const std::vector<std::size_t>& per_cent, std::size_t sectors = MovingShare::kSectors) {
  MovingShare share;
  for (std::size_t k = 0; k < per_cent.size(); ++k)
    share.add(40 + k, evenly(160 * per_cent[k], sectors), evenly(16'000));
  return share;
}

TEST(MovingShare, AcceptsTrafficThatComesAndGoes) {
  EXPECT_EQ(share_of({1, 2, 3, 5, 8, 12, 20, 30, 40, 50, 40, 20, 5, 1, 1, 10, 12}).trouble(), "");
}

TEST(MovingShare, AcceptsAnyShareInTheFirstScans) {
  EXPECT_EQ(share_of({0, 40, 0, 40, 0, 40}).trouble(), "");
}

// The static world moves at once where a scan is not in its place.
TEST(MovingShare, NamesTheScanInWhichTheShareRises) {
  EXPECT_THAT(share_of({1, 1, 1, 1, 1, 1, 1, 1, 1, 24, 3, 2, 2}).trouble(),
              HasSubstr("from 1 to 24 % at once in scan 49:"));
}

// A lorry that comes beside the sensor fills half of the view at most, and may be found within one scan.
TEST(MovingShare, AcceptsAVehicleThatFillsHalfOfTheView) {
  EXPECT_EQ(share_of({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 22, 18, 13, 20, 4, 0}, 8).trouble(), "");
}

TEST(MovingShare, FindsARunInWhichNearlyAllMoves) {
  EXPECT_THAT(share_of(std::vector<std::size_t>(20, 60)).trouble(), HasSubstr("60 % of all points"));
}

TEST(MovingShare, DoesNotJudgeScansOfFewPoints) {
  MovingShare share;
  for (std::size_t k = 0; k < 20; ++k) share.add(k, evenly(k % 2 == 0 ? 0 : 400), evenly(500));
  EXPECT_EQ(share.trouble(), "");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
