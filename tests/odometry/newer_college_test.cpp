#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/paths.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kColumns = 1024;
constexpr int kScansBefore = 5;
constexpr int kPasses = 3;
constexpr double kFastTurn = 1.5;  // [rad/s]
constexpr double kSurelyMatched = 0.75;
constexpr double kScanPeriod = 0.1006;  // [s] no shorter than any of the scans

std::vector<float> read_floats(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  std::vector<float> values(static_cast<std::size_t>(stream.tellg()) / sizeof(float));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(float)));
  return values;
}

Eigen::Matrix3Xd read_points(const std::filesystem::path& file) {
  const std::vector<float> values = read_floats(file);
  return Eigen::Map<const Eigen::Matrix3Xf>(values.data(), 3, static_cast<Eigen::Index>(values.size() / 3))
      .cast<double>();
}

/// One hand-held OS1-64 scan: points as measured, their times, and the same points as an inertial sensor's
/// motion compensated them. The reference is in the frame of that sensor, turned and shifted as the OS1's
/// data sheet says.
struct NewerCollegeScan {
  explicit NewerCollegeScan(int number) {
    const std::string name = fmt::format("newer_college_gtsam_points/newer_06/{{}}_{:02}.bin", number);
    const auto file = [&](const char* what) {
      return test::shared_data(fmt::format(fmt::runtime(name), what));
    };
    raw = read_points(file("raw"));
    times_s = read_floats(file("times"));
    const SE3 T_imu_lidar(rotation_z(std::acos(-1.0)), {-0.006253, 0.011775, -0.028535});
    const SE3 T_lidar_imu = T_imu_lidar.inverse();
    reference =
        (T_lidar_imu.rotation() * read_points(file("deskewed"))).colwise() + T_lidar_imu.translation();
  }
  Eigen::Matrix3Xd raw, reference;
  std::vector<float> times_s;
};

/// A scan of the points, `start_s` after the first, without every fifth point from number `left_out` on.
std::shared_ptr<const LidarScan> make_scan(const Eigen::Matrix3Xd& points, const std::vector<float>& times_s,
                                           double start_s, int left_out) {
  auto scan = std::make_shared<LidarScan>();
  scan->model = std::make_shared<const LidarModel>(named_model("OS1-64"));
  scan->start = Time::from_seconds(start_s);
  scan->column_period = Duration::from_seconds(kScanPeriod / kColumns);
  scan->columns = kColumns;
  scan->time_source = scan->ring_source = Provenance::sensor;
  scan->input_size = static_cast<std::size_t>(points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (left_out >= 0 && i % kScansBefore == left_out) continue;
    const auto time_ns = static_cast<std::int32_t>(1e9 * times_s[static_cast<std::size_t>(i)]);
    const auto column = static_cast<std::int32_t>(time_ns / scan->column_period.nanoseconds());
    const Eigen::Vector3f p = points.col(i).cast<float>();
    scan->returns.push_back(
        {p, p.norm(), time_ns, std::min(column, kColumns - 1), 0, static_cast<std::uint32_t>(i)});
  }
  scan->cells.assign(64 * kColumns, empty_cell(ReturnCode::absent));
  return scan;
}

/// The reference cloud as a sensor measures it that moves with `varpi` and reaches the reference pose
/// `until_s` later.
Eigen::Matrix3Xd seen_before(const NewerCollegeScan& data, const Vector6d& varpi, double until_s) {
  Eigen::Matrix3Xd points(3, data.reference.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double t = static_cast<double>(data.times_s[static_cast<std::size_t>(i)]) - until_s;
    points.col(i) = SE3::exp(t * varpi) * Eigen::Vector3d(data.reference.col(i));
  }
  return points;
}

struct Found {
  Vector6d varpi = Vector6d::Zero();  ///< mean over the scan
  Eigen::Matrix3Xd points;
  double inlier_ratio = 0;
};

/// The raw scan compensated by odometry, after five scans with motion `varpi`.
Found compensated_after(const NewerCollegeScan& data, const Vector6d& varpi) {
  LidarOdometry odometry;
  for (int k = 0; k < kScansBefore; ++k) {
    const double start = kScanPeriod * k;
    (void)odometry.process(
        make_scan(seen_before(data, varpi, kScanPeriod * kScansBefore - start), data.times_s, start, k));
  }
  const auto scan = make_scan(data.raw, data.times_s, kScanPeriod * kScansBefore, -1);
  const OdometryUpdate update = odometry.process(scan);
  const Trajectory& trajectory = odometry.trajectory();
  const CompensatedScan compensated = compensate(scan, trajectory);
  Found found;
  found.inlier_ratio = update.outcome == ScanOutcome::registered ? update.inlier_ratio : 0;
  found.points.resize(3, data.raw.cols());
  for (Eigen::Index i = 0; i < data.raw.cols(); ++i)
    found.points.col(i) = compensated.points_0[static_cast<std::size_t>(i)];
  const SE3 motion = trajectory.at(trajectory.end()).T_v0 * trajectory.at(scan->start).T_v0.inverse();
  found.varpi = motion.log() / (trajectory.end() - scan->start).seconds();
  return found;
}

/// The motion before the scan is estimated from the scan itself, in a few passes from several initial turn
/// rates. The pass with the highest inlier ratio is kept.
Found compensated(const NewerCollegeScan& data) {
  Found best;
  for (const double yaw_rate : {0.0, -0.6, 0.6, -1.2, 1.2}) {  // [rad/s]
    Found found;
    found.varpi[5] = yaw_rate;
    for (int pass = 0; pass < kPasses; ++pass) {
      found = compensated_after(data, found.varpi);
      if (found.inlier_ratio > best.inlier_ratio) best = found;
    }
    if (best.inlier_ratio > kSurelyMatched) break;
  }
  return best;
}

/// Distances to the reference, point by point, after one rigid alignment of the whole cloud.
std::vector<double> distances(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& reference) {
  const Eigen::Matrix4d T = Eigen::umeyama(points, reference, false);
  const Eigen::Matrix3Xd aligned =
      (T.topLeftCorner<3, 3>() * points).colwise() + T.topRightCorner<3, 1>().eval();
  const Eigen::VectorXd d = (aligned - reference).colwise().norm();
  return {d.begin(), d.end()};
}

/// Three scans of unrelated moments, each registered to its own reference cloud, as its authors' tests do. No
/// scan precedes them: the sensor is taken to have moved before as it did within the scan (see
/// compensated()). The reference motion is not used.
TEST(NewerCollege, CompensationAgreesWithTheReference) {
  MAPLESS_SKIP_WITHOUT(test::shared_data("newer_college_gtsam_points/newer_06/raw_00.bin"));
  for (int number = 0; number < 3; ++number) {
    SCOPED_TRACE(number);
    const NewerCollegeScan data(number);
    const Found found = compensated(data);
    const auto raw = distances(data.raw, data.reference);
    const auto ours = distances(found.points, data.reference);
    fmt::print(
        "scan {}: {:.0f} deg/s, {:.2f} m/s; distance to the reference, median and 95 %: raw {:.3f} {:.3f} "
        "m, compensated {:.3f} {:.3f} m\n",
        number, found.varpi.tail<3>().norm() * 180 / std::acos(-1.0), found.varpi.head<3>().norm(),
        *quantile(raw, 0.5), *quantile(raw, 0.95), *quantile(ours, 0.5), *quantile(ours, 0.95));
    EXPECT_LT(*quantile(ours, 0.5), 0.25 * *quantile(raw, 0.5));
    EXPECT_LT(*quantile(ours, 0.95), 0.25 * *quantile(raw, 0.95));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
