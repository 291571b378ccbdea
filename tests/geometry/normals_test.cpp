#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "geometry/nearest_neighbours.hpp"
#include "support/cast_rays.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::awkward_model;
using test::cast_rays;
using test::RangeOfRay;
using test::ScrewTrajectory;

const Time kStart = Time::from_seconds(1000);
constexpr double kDegree = std::numbers::pi / 180;

struct Plane {
  Eigen::Vector3d normal;  // unit
  double offset;           // normal . p = offset on the plane
};

// The nearest plane a ray meets within 100 m.
RangeOfRay planes_of(std::vector<Plane> planes) {
  return [planes](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    std::optional<double> nearest;
    for (const Plane& plane : planes) {
      const double range = (plane.offset - plane.normal.dot(origin)) / plane.normal.dot(direction);
      if (range > 0.5 && range < 100 && (!nearest || range < *nearest)) nearest = range;
    }
    return nearest;
  };
}

// Inside a box of 20 x 14 x 6 m.
const std::vector<Plane> kRoom = {{{1, 0, 0}, 10}, {{1, 0, 0}, -10}, {{0, 1, 0}, 7},
                                  {{0, 1, 0}, -7}, {{0, 0, 1}, 4},   {{0, 0, 1}, -2}};

ScrewTrajectory drive(const SE3& T_v0) {
  const Vector6d varpi = (Vector6d() << -8, 0, 0, 0, 0, -0.6).finished();
  return {T_v0, varpi, kStart, kStart + Duration::from_seconds(0.2)};
}

CompensatedScan scan_of(const std::vector<Plane>& planes, const Trajectory& trajectory, int lasers = 32,
                        int columns = 720) {
  return compensate(std::make_shared<LidarScan>(
                        cast_rays(awkward_model(lasers, columns), kStart, trajectory, planes_of(planes))),
                    trajectory);
}

CompensatedScan scan_of(const std::vector<Plane>& planes) { return scan_of(planes, drive(SE3())); }

std::vector<Eigen::Vector3f> normals_of(const CompensatedScan& scan, const NormalParameters& parameters) {
  return estimate_normals(scan, NearestNeighbours(scan.points_0), parameters);
}

NormalParameters with(NormalMethod method) {
  NormalParameters parameters;
  parameters.method = method;
  return parameters;
}

// The plane of the room a point lies on, where no other is within `margin`.
const Plane* wall_of(const Eigen::Vector3d& p, double margin) {
  const Plane* wall = nullptr;
  for (const Plane& plane : kRoom) {
    const double distance = std::abs(plane.normal.dot(p) - plane.offset);
    if (distance > margin) continue;
    if (wall != nullptr) return nullptr;
    wall = &plane;
  }
  return wall;
}

class NormalsOfBothMethods : public testing::TestWithParam<NormalMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, NormalsOfBothMethods,
                         testing::Values(NormalMethod::image_window, NormalMethod::nearest_neighbours),
                         [](const auto& param) {
                           return std::string(
                               choice_names(param.param)[static_cast<std::size_t>(param.param)]);
                         });

// Away from edges every normal there is is that of the wall, and points into the room.
TEST_P(NormalsOfBothMethods, AgreeWithTheWallsOfARoom) {
  const CompensatedScan scan = scan_of(kRoom);
  const auto normals = normals_of(scan, with(GetParam()));
  ASSERT_EQ(normals.size(), scan.points_0.size());
  int queried = 0, found = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    // No window reaches farther along a wall than to the next laser's return, about 1.6 m here.
    const Plane* wall = wall_of(scan.points_0[i], 1.8);
    if (wall == nullptr) continue;
    ++queried;
    if (normals[i].isZero()) continue;
    ++found;
    const Eigen::Vector3d n = normals[i].cast<double>();
    ASSERT_NEAR(n.norm(), 1, 1e-6);
    // Single points are off by the rounding of positions to float and of the sensor's motion to first order:
    // microns.
    ASSERT_GT(std::abs(n.dot(wall->normal)), 1 - 1e-6) << i;
    ASSERT_LT(n.dot(wall->normal) * (wall->offset > 0 ? 1 : -1), 0) << "points out of the room";
  }
  EXPECT_GT(queried, 10'000);
  EXPECT_GT(found, (GetParam() == NormalMethod::image_window ? 0.8 : 0.3) * queried);
}

// Both sides of a thin wall are hit by no ray, but one wall can be seen from both sides by a sensor that
// passes through: the normal follows the ray's own origin, not that of the scan.
TEST_P(NormalsOfBothMethods, PointTowardsTheOriginOfTheirOwnRay) {
  const Vector6d varpi = (Vector6d() << -40, 0, 0, 0, 0, 0).finished();
  const ScrewTrajectory through(SE3(), varpi, kStart, kStart + Duration::from_seconds(0.2));
  const Plane wall{{1, 0, 0}, 2};  // the sensor is there at mid-scan
  const CompensatedScan scan = scan_of({wall}, through);
  const auto normals = normals_of(scan, with(GetParam()));
  int towards_minus = 0, towards_plus = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i].isZero()) continue;
    const LidarReturn& r = scan.scan->returns[i];
    const Eigen::Vector3d to_origin = scan.ray_origin_0(r.laser, r.column) - scan.points_0[i];
    ASSERT_GT(normals[i].cast<double>().dot(to_origin), 0);
    (normals[i].x() < 0 ? towards_minus : towards_plus) += 1;
  }
  EXPECT_GT(towards_minus, 100);
  EXPECT_GT(towards_plus, 100);
}

TEST_P(NormalsOfBothMethods, FewerThanMinPointsGiveNone) {
  const CompensatedScan scan = scan_of(kRoom);
  NormalParameters parameters = with(GetParam());
  parameters.min_points = 22;  // the window holds 21
  parameters.neighbours = 21;
  for (const Eigen::Vector3f& n : normals_of(scan, parameters)) ASSERT_TRUE(n.isZero());
  parameters.min_points = 21;
  const auto normals = normals_of(scan, parameters);
  EXPECT_TRUE(std::any_of(normals.begin(), normals.end(), [](const auto& n) { return !n.isZero(); }));
}

// One laser sees a curve: on a flat wall, a line. Lines have no normal.
TEST_P(NormalsOfBothMethods, PointsOnALineGiveNone) {
  const CompensatedScan scan = scan_of({kRoom[0]}, StationaryTrajectory(), 1, 2000);
  ASSERT_GT(scan.points_0.size(), 100u);
  for (const Eigen::Vector3f& n : normals_of(scan, with(GetParam()))) ASSERT_TRUE(n.isZero());
  NormalParameters any_width = with(GetParam());
  any_width.min_width_ratio = 0;
  LidarScan level = *scan.scan;  // exactly on a line
  for (LidarReturn& r : level.returns) r.position_v = {5, r.position_v.y(), 0};
  const CompensatedScan line = compensate(std::make_shared<LidarScan>(level), StationaryTrajectory());
  for (const Eigen::Vector3f& n : normals_of(line, any_width)) ASSERT_TRUE(n.isZero());
}

// Points scattered in a ball of half a metre are no plane: thickness and width are alike.
TEST_P(NormalsOfBothMethods, ScatteredPointsMostlyGiveNone) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.5);
  LidarScan foliage = *scan_of(kRoom).scan;
  for (LidarReturn& r : foliage.returns) {
    r.position_v += Eigen::Vector3d(noise(random), noise(random), noise(random)).cast<float>();
  }
  const StationaryTrajectory still;
  NormalParameters parameters = with(GetParam());
  parameters.gate_m = 10;
  const auto normals = normals_of(compensate(std::make_shared<LidarScan>(foliage), still), parameters);
  const auto found = std::count_if(normals.begin(), normals.end(), [](const auto& n) { return !n.isZero(); });
  EXPECT_LT(static_cast<double>(found), 0.25 * static_cast<double>(normals.size()));
}

TEST_P(NormalsOfBothMethods, DuplicatePointsGiveNone) {
  LidarScan scan = *scan_of(kRoom, StationaryTrajectory(), 8, 100).scan;
  for (LidarReturn& r : scan.returns) r.position_v = {3, 4, 5};
  const auto normals =
      normals_of(compensate(std::make_shared<LidarScan>(scan), StationaryTrajectory()), with(GetParam()));
  for (const Eigen::Vector3f& n : normals) ASSERT_TRUE(n.isZero());
}

TEST_P(NormalsOfBothMethods, RotateWithTheWorldFrame) {
  const SE3 T_0w = SE3::exp((Vector6d() << 5000, -3000, 40, 0.7, -1.1, 2.0).finished());
  std::vector<Plane> turned_room;
  for (const Plane& plane : kRoom) {
    const Eigen::Vector3d normal = T_0w.rotation() * plane.normal;
    turned_room.push_back({normal, plane.offset + normal.dot(T_0w.translation())});
  }
  const CompensatedScan scan = scan_of(kRoom, drive(SE3()));
  const CompensatedScan turned = scan_of(turned_room, drive(T_0w.inverse()));
  ASSERT_EQ(scan.points_0.size(), turned.points_0.size());
  const auto normals = normals_of(scan, with(GetParam()));
  const auto turned_normals = normals_of(turned, with(GetParam()));
  std::size_t different = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    different += (T_0w.rotation().cast<float>() * normals[i] - turned_normals[i]).norm() > 1e-3f;
  }
  EXPECT_LT(different, normals.size() / 500);  // neighbours at exactly the gate, ties
}

TEST_P(NormalsOfBothMethods, OneThreadAndSeveralGiveTheSameBytes) {
  const CompensatedScan scan = scan_of(kRoom);
  const auto several = normals_of(scan, with(GetParam()));
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(normals_of(scan, with(GetParam())), several);
}

TEST_P(NormalsOfBothMethods, AcceptsEmptyScansAndWindowsWiderThanTheScan) {
  EXPECT_TRUE(normals_of(scan_of({}), with(GetParam())).empty());
  NormalParameters wide = with(GetParam());
  wide.window_columns = 31;
  wide.window_rows = 15;
  const CompensatedScan small = scan_of(kRoom, drive(SE3()), 3, 8);
  EXPECT_EQ(normals_of(small, wide).size(), small.points_0.size());
}

// In the raw image, neighbouring lasers look 15 or 60 degrees apart here: the window must follow the azimuth
// offsets to find neighbours in space, also across the seam.
TEST(Normals, TheWindowFollowsTheAzimuthOffsetsAcrossTheSeam) {
  auto model = std::make_shared<LidarModel>(*awkward_model(32, 720));
  for (Laser& laser : model->lasers) laser.azimuth_offset_rad *= 6;
  const StationaryTrajectory still;
  const CompensatedScan scan =
      compensate(std::make_shared<LidarScan>(cast_rays(model, kStart, still, planes_of(kRoom))), still);
  const auto normals = normals_of(scan, with(NormalMethod::image_window));
  int at_seam = 0, found = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const LidarReturn& r = scan.scan->returns[i];
    const bool seam = r.column < 3 || r.column >= scan.scan->columns - 3;
    if (!seam || r.laser == 0 || r.laser == scan.scan->rows() - 1) continue;
    const Plane* wall = wall_of(scan.points_0[i], 1.0);
    if (wall == nullptr || wall->normal.z() != 0) continue;  // on the floor rings are too far apart
    ++at_seam;
    found += !normals[i].isZero();
  }
  EXPECT_GT(at_seam, 60);
  EXPECT_GT(found, 0.95 * at_seam);
}

// Around a point whose range differs from its neighbours' by more than the gate, nothing counts.
TEST(Normals, TheGateExcludesOtherSurfaces) {
  LidarScan scan = *scan_of(kRoom, StationaryTrajectory()).scan;
  const std::size_t i = scan.returns.size() / 2;
  scan.returns[i].position_v *= 0.5f;
  const CompensatedScan compensated = compensate(std::make_shared<LidarScan>(scan), StationaryTrajectory());
  NormalParameters parameters;
  EXPECT_TRUE(normals_of(compensated, parameters)[i].isZero());
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
