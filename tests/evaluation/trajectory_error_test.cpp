#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/paths.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;

SE3 at_x(double x) { return {Eigen::Matrix3d::Identity(), {x, 0, 0}}; }

Time scan_time(std::size_t k) { return Time::from_nanoseconds(100'000'000LL * static_cast<int>(k)); }

// One metre a scan straight on.
std::vector<PosePair> straight_drive(std::size_t poses, const std::function<SE3(double)>& estimated) {
  std::vector<PosePair> pairs;
  for (std::size_t k = 0; k < poses; ++k) {
    const auto x = static_cast<double>(k);
    pairs.push_back({k, scan_time(k), at_x(x), estimated(x)});
  }
  return pairs;
}

// The estimate's world need not be the true one.
SE3 elsewhere() { return {so3_exp({0.3, -0.4, 2}), {100, -20, 7}}; }

std::vector<PosePair> one_percent_too_long(std::size_t poses) {
  return straight_drive(poses, [](double x) { return elsewhere() * at_x(1.01 * x); });
}

TEST(TrajectoryError, AScaleErrorGivesThatDrift) {
  const auto pairs = one_percent_too_long(300);
  EXPECT_NEAR(path_length_m(pairs), 299, 1e-9);
  const auto found = drift(pairs).value();
  // The first pose beyond 100 m is at 101 m, where the error is 1.01 m. Segments begin at 0, 10 ... 190.
  ASSERT_EQ(found.by_length.size(), 2u);
  EXPECT_EQ(found.by_length[0].length_m, 100);
  EXPECT_EQ(found.by_length[0].segments, 20u);
  EXPECT_NEAR(found.by_length[0].translation_percent, 1.01, 1e-9);
  EXPECT_EQ(found.by_length[1].segments, 10u);
  EXPECT_NEAR(found.by_length[1].translation_percent, 1.005, 1e-9);
  EXPECT_EQ(found.segments, 30u);
  EXPECT_NEAR(found.translation_percent, (20 * 1.01 + 10 * 1.005) / 30, 1e-9);
  EXPECT_NEAR(found.rotation_deg_per_100m, 0, 1e-5);
}

TEST(TrajectoryError, AScaleErrorGivesTheOtherErrors) {
  const auto pairs = one_percent_too_long(300);
  const PoseErrors per_scan = relative_error_per_scan(pairs).value();
  EXPECT_EQ(per_scan.translation_m.count, 299u);
  for (const double figure :
       {per_scan.translation_m.rmse, per_scan.translation_m.mean, per_scan.translation_m.median,
        per_scan.translation_m.p95, per_scan.translation_m.max}) {
    EXPECT_NEAR(figure, 0.01, 1e-9);
  }
  EXPECT_EQ(relative_error_per_scan(pairs, 290)->translation_m.count, 9u);
  EXPECT_FALSE(relative_error_per_scan(pairs, 299));
  const PoseErrors from_first = absolute_error_from_first(pairs).value();
  EXPECT_NEAR(from_first.translation_m.max, 2.99, 1e-9);
  // Of 0, 1 ... n - 1: the mean square is (n - 1)(2n - 1) / 6, the variance (n^2 - 1) / 12.
  EXPECT_NEAR(from_first.translation_m.rmse, 0.01 * std::sqrt(299.0 * 599.0 / 6), 1e-9);
  const ErrorFigures aligned = absolute_error_aligned(pairs).value();
  EXPECT_NEAR(aligned.rmse, 0.01 * std::sqrt((300.0 * 300.0 - 1) / 12), 1e-9);
  EXPECT_NEAR(aligned.max, 1.495, 1e-9);
}

TEST(TrajectoryError, AYawRateErrorGivesThatDrift) {
  // 0.02 degrees a scan too much: the estimate goes straight on in its own frame, round in the world.
  const SE3 turn(rotation_z(0.02 * kDegree), {1, 0, 0});
  SE3 estimated;
  const auto pairs = straight_drive(250, [&](double x) {
    if (x > 0) estimated = estimated * turn;
    return estimated;
  });
  const auto found = drift(pairs).value();
  ASSERT_EQ(found.by_length.size(), 2u);
  EXPECT_NEAR(found.by_length[0].rotation_deg_per_100m, 101 * 0.02, 1e-6);
  EXPECT_NEAR(found.by_length[1].rotation_deg_per_100m, 201 * 0.02 / 2, 1e-6);
  const PoseErrors per_scan = relative_error_per_scan(pairs).value();
  EXPECT_NEAR(per_scan.rotation_deg.rmse, 0.02, 1e-6);
  EXPECT_NEAR(per_scan.translation_m.max, 0, 1e-9);
  EXPECT_NEAR(absolute_error_from_first(pairs)->rotation_deg.max, 249 * 0.02, 1e-6);
}

TEST(TrajectoryError, ShortDrivesHaveShorterSegments) {
  // 30 m: of 50, 20, 10 ... the longest that goes in twice is 10.
  const auto found = drift(one_percent_too_long(31)).value();
  ASSERT_EQ(found.by_length.size(), 2u);
  EXPECT_EQ(found.by_length[0].length_m, 10);
  EXPECT_EQ(found.by_length[0].segments, 20u) << "begun at 0 to 19";
  EXPECT_NEAR(found.by_length[0].translation_percent, 1.1, 1e-9);
  EXPECT_EQ(found.by_length[1].length_m, 20);
  EXPECT_EQ(found.by_length[1].segments, 10u);
  EXPECT_FALSE(drift(one_percent_too_long(2)));
  EXPECT_FALSE(drift({}));
}

TEST(TrajectoryError, AMissingScanEndsNoSegmentButGivesNoRelativeError) {
  auto pairs = one_percent_too_long(300);
  pairs.erase(pairs.begin() + 50, pairs.begin() + 55);
  EXPECT_EQ(relative_error_per_scan(pairs)->translation_m.count, 293u) << "one gap, five scans";
  EXPECT_NEAR(relative_error_per_scan(pairs)->translation_m.max, 0.01, 1e-9);
  EXPECT_NEAR(path_length_m(pairs), 299, 1e-9);
  EXPECT_NEAR(drift(pairs)->translation_percent, 1.0, 0.02);
}

TEST(TrajectoryError, ErrorsOfTooFewPosesAreAbsent) {
  const auto pairs = one_percent_too_long(1);
  EXPECT_FALSE(relative_error_per_scan(pairs));
  EXPECT_FALSE(absolute_error_from_first(pairs));
  EXPECT_FALSE(absolute_error_aligned(pairs));
  EXPECT_FALSE(figures_of({}));
  EXPECT_EQ(path_length_m({}), 0);
}

std::map<std::string, double> read_figures(const std::string& file) {
  std::map<std::string, double> figures;
  std::ifstream stream(file);
  for (std::string name; stream >> name;) stream >> figures[name];
  return figures;
}

// What evo 1.38.1 and KISS-ICP's port of KITTI's devkit say of these two files;
// benchmarks/peers/make_trajectory_figures.py made them.
TEST(TrajectoryError, AgreesWithEvoAndTheKittiDevkit) {
  const std::string folder = test::test_file("evaluation/trajectory_figures/").string();
  const auto truth = read_trajectory_file(folder + "true.txt", {}).poses();
  const auto estimated = read_trajectory_file(folder + "estimated.txt", {}).poses();
  auto figures = read_figures(folder + "figures.txt");
  ASSERT_EQ(figures.size(), 16u);
  std::vector<PosePair> pairs;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    pairs.push_back({k, truth[k].time, truth[k].T_v0.inverse(), estimated[k].T_v0.inverse()});
  }
  const auto expect_all = [&](const std::string& name, const ErrorFigures& found) {
    EXPECT_NEAR(found.rmse, figures.at(name + "_rmse"), 1e-6) << name;
    EXPECT_NEAR(found.mean, figures.at(name + "_mean"), 1e-6) << name;
    EXPECT_NEAR(found.median, figures.at(name + "_median"), 1e-6) << name;
    EXPECT_NEAR(found.max, figures.at(name + "_max"), 1e-6) << name;
  };
  const PoseErrors per_scan = relative_error_per_scan(pairs).value();
  expect_all("rpe_translation_m", per_scan.translation_m);
  expect_all("rpe_rotation_deg", per_scan.rotation_deg);
  expect_all("aligned_m", absolute_error_aligned(pairs).value());
  const PoseErrors from_first = absolute_error_from_first(pairs).value();
  EXPECT_NEAR(from_first.translation_m.rmse, figures.at("from_first_translation_m_rmse"), 1e-6);
  EXPECT_NEAR(from_first.rotation_deg.rmse, figures.at("from_first_rotation_deg_rmse"), 1e-6);
  EXPECT_NEAR(drift(pairs)->translation_percent, figures.at("kitti_translation_percent"), 1e-5);
  EXPECT_NEAR(drift(pairs)->rotation_deg_per_100m, figures.at("kitti_rotation_deg_per_100m"), 1e-4);
}

TEST(TrajectoryError, PairsOutOfOrderAreRefused) {
  auto pairs = one_percent_too_long(300);
  std::swap(pairs[10], pairs[11]);
  EXPECT_THROW((void)drift(pairs), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
