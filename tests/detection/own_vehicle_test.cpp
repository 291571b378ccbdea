#include "detection/own_vehicle.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/small_scan.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kTolerance_m = 0.08;
constexpr int kFirstOwn = 5, kLastOwn = 14;  // columns of the bonnet, in every row

SE3 after(double distance_m, double turned_rad = 0) {
  return {rotation_z(turned_rad), Eigen::Vector3d(-distance_m, 0, 0)};
}

// A world 3 m away that comes nearer by `approached_m`, and a bonnet at 1.5 m.
LidarScan scan_at(double approached_m, double bonnet_m = 1.5) {
  LidarScan scan = test::small_scan({0, 0}, 3);
  for (LidarReturn& r : scan.returns) {
    const bool own = r.column >= kFirstOwn && r.column <= kLastOwn;
    r.range_m = static_cast<float>(own ? bonnet_m : 3 - approached_m);
  }
  return scan;
}

std::vector<std::int32_t> learn_and_find(OwnVehicle& own, const LidarScan& scan, const SE3& T_v0) {
  own.learn(scan, T_v0, kTolerance_m);
  return own.find(scan, kTolerance_m);
}

// What is found in the last of `scans` scans of one model, `step` apart. The bonnet is there from scan
// `appears` on.
std::size_t found_after(int scans, double step_m, double turn_rad = 0, int appears = 0,
                        double bonnet_m = 1.5) {
  OwnVehicle own;
  LidarScan first = scan_at(0);
  std::size_t found = 0;
  for (int k = 0; k < scans; ++k) {
    LidarScan scan = scan_at(0.1 * k, k < appears ? 20 : bonnet_m);
    scan.model = first.model;
    found = learn_and_find(own, scan, after(step_m * k, turn_rad * k)).size();
  }
  return found;
}

constexpr std::size_t kBonnet = 2 * (kLastOwn - kFirstOwn + 1);

TEST(OwnVehicle, IsWhatKeepsItsRangeWhileTheSensorMoves) {
  EXPECT_EQ(found_after(4, 0.06), 0U);  // four key scans do not suffice
  EXPECT_EQ(found_after(5, 0.06), kBonnet);
  EXPECT_EQ(found_after(5, 0, 0.03), kBonnet);  // turned on the spot
}

// The end of a trailer, 17 m behind the sensor; what is 19 m away is none of a carrier.
TEST(OwnVehicle, MayBeAsLongAsALorryWithTrailer) {
  EXPECT_EQ(found_after(5, 0.12, 0, 0, 17), kBonnet);
  EXPECT_EQ(found_after(20, 0.12, 0, 0, 19), 0U);
}

// 20 scans at one place are one key scan.
TEST(OwnVehicle, IsLearntInFiveKeyScansAfterAStop) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  for (int k = 0; k < 24; ++k) {
    LidarScan scan = scan_at(0.1 * std::max(0, k - 19));
    scan.model = first.model;
    const std::size_t found = learn_and_find(own, scan, after(0.12 * std::max(0, k - 19))).size();
    EXPECT_EQ(found, k < 23 ? 0U : kBonnet) << "scan " << k;
  }
}

// What is there from the second scan on has to be there in ten.
TEST(OwnVehicle, TakesTenKeyScansAfterTheFirst) {
  EXPECT_EQ(found_after(10, 0.12, 0, 1), 0U);
  EXPECT_EQ(found_after(11, 0.12, 0, 1), kBonnet);
}

// What is found on the bonnet in the last of ten key scans, where the range is `range_m(column, k)`.
template <typename Range>
std::size_t found_on(const std::vector<int>& bonnet, const Range& range_m) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  std::size_t found = 0;
  for (int k = 0; k < 10; ++k) {
    LidarScan scan = test::small_scan({0, 0}, 3);
    scan.model = first.model;
    const auto on_bonnet = [&](int c) { return std::find(bonnet.begin(), bonnet.end(), c) != bonnet.end(); };
    for (LidarReturn& r : scan.returns) r.range_m = on_bonnet(r.column) ? 1.5F : range_m(r.column, k);
    found = 0;
    for (const std::int32_t i : learn_and_find(own, scan, after(0.6 * k)))
      if (on_bonnet(scan.returns[static_cast<std::size_t>(i)].column)) ++found;
  }
  return found;
}

TEST(OwnVehicle, ReachesOverTheSeam) {
  const std::vector<int> bonnet = {20, 21, 22, 23, 0, 1, 2, 3, 4};
  EXPECT_EQ(found_on(bonnet, [](int, int k) { return 3 - 0.1F * static_cast<float>(k); }), 2 * bonnet.size());
}

// Flat ground keeps its range, too; in columns 16 to 19 something comes nearer.
TEST(OwnVehicle, EndsAtFlatGround) {
  const std::vector<int> bonnet = {5, 6, 7, 8, 9, 10};
  const auto ground = [](int c, int k) { return c >= 16 && c <= 19 ? 3 - 0.1F * static_cast<float>(k) : 3; };
  EXPECT_EQ(found_on(bonnet, ground), 2 * bonnet.size());
}

// The deck of a robot, all around: it has no end.
TEST(OwnVehicle, MayBeAllAround) {
  std::vector<int> deck(test::kSmallColumns);
  std::iota(deck.begin(), deck.end(), 0);
  EXPECT_EQ(found_on(deck, [](int, int) { return 3.F; }), 2 * deck.size());
}

// What is found in the last of `scans` key scans, where the bonnet has range `range_m(k)` and gives a return
// where `returns(column, k)`: at most those of the last scan.
template <typename Range, typename Returns>
std::size_t found_of_bonnet(int scans, const Range& range_m, const Returns& returns) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  std::size_t found = 0;
  for (int k = 0; k < scans; ++k) {
    std::vector<char> missing;
    for (int i = 0; i < 2 * test::kSmallColumns; ++i) missing.push_back(!returns(i % test::kSmallColumns, k));
    LidarScan scan = test::small_scan({0, 0}, 3 - 0.1 * k, missing);
    scan.model = first.model;
    for (LidarReturn& r : scan.returns)
      if (r.column >= kFirstOwn && r.column <= kLastOwn) r.range_m = static_cast<float>(range_m(k));
    found = learn_and_find(own, scan, after(0.6 * k)).size();
  }
  return found;
}

// Its first range is 0.06 m too large, two more of twelve are 0.03 m too small: 0.09 m apart.
TEST(OwnVehicle, HasNoisyRanges) {
  const auto range_m = [](int k) { return k == 0 ? 1.56 : k == 5 || k == 8 ? 1.47 : 1.5; };
  EXPECT_EQ(found_of_bonnet(12, range_m, [](int, int) { return true; }), kBonnet);
}

// Dark paint returns every second firing.
TEST(OwnVehicle, MayBeDark) {
  const auto every_second = [](int c, int k) { return (c + k) % 2 == 0; };
  EXPECT_EQ(found_of_bonnet(
                5, [](int) { return 1.5; }, every_second),
            kBonnet / 2);
}

// Columns 6 to 13 give no return in the second of five key scans, so that four cells have only four.
TEST(OwnVehicle, ReachesOverCellsOfFewReturns) {
  const auto gap = [](int c, int k) { return k != 1 || c < 6 || c > 13; };
  EXPECT_EQ(found_of_bonnet(
                5, [](int) { return 1.5; }, gap),
            kBonnet);
}

// No ray of the bonnet comes back in the second scan of six: five of six are eight tenths.
TEST(OwnVehicle, MayLackReturnsInOneScanOfSix) {
  const auto all_but_second = [](int, int k) { return k != 1; };
  EXPECT_EQ(found_of_bonnet(
                5, [](int) { return 1.5; }, all_but_second),
            0U);
  EXPECT_EQ(found_of_bonnet(
                6, [](int) { return 1.5; }, all_but_second),
            kBonnet);
}

TEST(OwnVehicle, IsNotLearntWhileTheSensorStands) {
  EXPECT_EQ(found_after(100, 0), 0U);
  EXPECT_EQ(found_after(100, 0.0004), 0U);  // 0.04 m: no second key scan
}

TEST(OwnVehicle, IsNothingInFrontOfIt) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  for (int k = 0; k < 20; ++k) {
    LidarScan scan = scan_at(0.1 * k);
    scan.model = first.model;
    own.learn(scan, after(0.6 * k), kTolerance_m);
  }
  LidarScan person = scan_at(0, 1.4);  // 0.1 m in front of the bonnet: more than the tolerance
  person.model = first.model;
  EXPECT_TRUE(own.find(person, kTolerance_m).empty());
}

// A side that passes at a constant distance after 20 key scans of something else: 20 of at most 10 that
// count against it take 90 key scans, until it is the own vehicle: scans 20 to 109.
TEST(OwnVehicle, IsNoSideThatPassesForSeconds) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  for (int k = 0; k < 112; ++k) {
    LidarScan scan = scan_at(0, k < 20 ? 3.5 - 0.1 * k : 1.0);
    for (LidarReturn& r : scan.returns)
      if (r.range_m == 3) r.range_m = 20;
    scan.model = first.model;
    ASSERT_EQ(learn_and_find(own, scan, after(0.6 * k)).empty(), k < 109) << "scan " << k;
  }
}

// The side of a lorry at a constant distance: it reaches from column 3 to its front, which advances by a
// column a scan: the last columns are not constant yet.
TEST(OwnVehicle, IsNoSideWhoseEndMoves) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  for (int k = 0; k < 12; ++k) {
    LidarScan scan = test::small_scan({0, 0}, 3);
    for (LidarReturn& r : scan.returns) r.range_m = r.column >= 3 && r.column <= 10 + k ? 2.5F : 20.0F;
    scan.model = first.model;
    EXPECT_TRUE(learn_and_find(own, scan, after(0.6 * k)).empty()) << "scan " << k;
  }
}

// The same of dark paint, where every second firing returns: two of the four columns beyond the constant ones
// have a return, as many as beside an end that stays.
TEST(OwnVehicle, IsNoDarkSideWhoseEndMoves) {
  OwnVehicle own;
  const LidarScan first = scan_at(0);
  for (int k = 0; k < 12; ++k) {
    const auto on_side = [&](int column) { return column >= 3 && column <= 10 + k; };
    std::vector<char> missing;
    for (int i = 0; i < 2 * test::kSmallColumns; ++i) {
      const int column = i % test::kSmallColumns;
      missing.push_back(static_cast<char>(on_side(column) && (column + k) % 2 == 1));
    }
    LidarScan scan = test::small_scan({0, 0}, 3, missing);
    for (LidarReturn& r : scan.returns) r.range_m = on_side(r.column) ? 2.5F : 20.0F;
    scan.model = first.model;
    EXPECT_TRUE(learn_and_find(own, scan, after(0.6 * k)).empty()) << "scan " << k;
  }
}

// What is found of a bonnet in five rows in the last of `scans` key scans, where something that moves, at
// most 0.15 m nearer or farther, is beside it in the lowest `touched` rows, in scan `from` and later.
std::size_t found_where_touched(int touched, int from = 0, int scans = 8) {
  OwnVehicle own;
  const std::vector<double> lasers(5, 0);
  const LidarScan first = test::small_scan(lasers, 3);
  std::size_t found = 0;
  for (int k = 0; k < scans; ++k) {
    LidarScan scan = test::small_scan(lasers, 4 - 0.1 * k);
    scan.model = first.model;
    for (LidarReturn& r : scan.returns) {
      const bool touches = k >= from && r.laser < touched && r.column > kLastOwn && r.column <= kLastOwn + 4;
      if (r.column >= kFirstOwn && r.column <= kLastOwn) r.range_m = 1.5F;
      if (touches) r.range_m = 1.35F + 0.1F * static_cast<float>(k % 4);
    }
    found = learn_and_find(own, scan, after(0.6 * k)).size();
  }
  return found;
}

// Two of five rows of one body do not end freely: three say that it is the own vehicle. Three do not: it is
// not.
TEST(OwnVehicle, IsABodyMostOfWhichEndsFreely) {
  EXPECT_EQ(found_where_touched(2), 5 * kBonnet / 2);
  EXPECT_EQ(found_where_touched(3), 0U);
}

// What comes to its ends in a later scan does not make another body of it at once: it was found in more than
// five scans, and five speak against it.
TEST(OwnVehicle, IsRememberedForFiveKeyScans) {
  EXPECT_EQ(found_where_touched(3, 10, 13), 5 * kBonnet / 2);
  EXPECT_EQ(found_where_touched(3, 10, 16), 0U);
}

// `own` drives with the sensor at `speed_mps`: of scans `first` to 25, the points that move.
std::size_t moving_points(test::ToyBody own, double speed_mps, int first, bool learn) {
  test::ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model("OS1-64"));
  scene.trajectory = test::drive(speed_mps, 0);
  own.velocity_0 = {speed_mps, 0, 0};
  scene.world = {test::toy_ground(-1.5), test::toy_box({40, 0, 0}, {1, 20, 5}), own};
  Detector detector;
  std::size_t moving = 0;
  for (int k = 0; k < 26; ++k) {
    const auto scan = test::cast_scan(scene, k).scan;
    if (k >= first) {
      moving += test::moving_points(detector.process(scan, *scene.trajectory));
    } else if (learn) {
      detector.learn_own_vehicle(*scan, *scene.trajectory);
    }
  }
  return moving + test::moving_points(detector.flush());
}

const test::ToyBody kBox = test::toy_box({2, 0, -0.2}, {0.2, 0.4, 0.3});        // before the sensor
const test::ToyBody kBusRoof = test::toy_box({-3.5, 0, -0.7}, {5, 1.25, 0.2});  // from 8.5 m behind it

TEST(OwnVehicle, IsKnownFromScansThatAreNotLabelled) {
  EXPECT_GT(moving_points(kBox, 0.4, 15, false), 0U);
  EXPECT_EQ(moving_points(kBox, 0.4, 15, true), 0U);
}

// The first five scans wait for one another: the own vehicle is known before any is labelled.
TEST(OwnVehicle, IsKnownFromTheFirstScanOnAtHalfAMetreASecond) {
  EXPECT_EQ(moving_points(kBox, 0.6, 0, false), 0U);
  EXPECT_EQ(moving_points(kBusRoof, 0.6, 0, false), 0U);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
