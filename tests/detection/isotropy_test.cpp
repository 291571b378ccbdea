#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Scans = std::vector<std::shared_ptr<const LidarScan>>;

/// The motion of a sensor whose frame is turned by `angle_rad` about its z.
class TurnedSensor final : public Trajectory {
 public:
  TurnedSensor(std::shared_ptr<const Trajectory> trajectory, double angle_rad)
      : trajectory_(std::move(trajectory)), T_wv_(rotation_z(angle_rad), Eigen::Vector3d::Zero()) {}
  [[nodiscard]] Time begin() const override { return trajectory_->begin(); }
  [[nodiscard]] Time end() const override { return trajectory_->end(); }
  [[nodiscard]] TrajectoryState at(Time t) const override {
    const TrajectoryState s = trajectory_->at(t);
    Vector6d varpi;
    varpi << T_wv_.rotation() * s.varpi.head<3>(), T_wv_.rotation() * s.varpi.tail<3>();
    return {T_wv_ * s.T_v0, varpi};
  }

 private:
  std::shared_ptr<const Trajectory> trajectory_;
  SE3 T_wv_;
};

/// The same scans in the frame of a sensor that is turned by `angle_rad` about its z.
Scans in_turned_frame(const Scans& scans, double angle_rad) {
  auto model = std::make_shared<LidarModel>(*scans.front()->model);
  model->start_azimuth_rad += angle_rad;
  Scans turned;
  for (const auto& scan : scans) {
    auto copy = std::make_shared<LidarScan>(*scan);
    copy->model = model;
    for (LidarReturn& r : copy->returns)
      r.position_v = (rotation_z(angle_rad) * r.position_v.cast<double>()).cast<float>();
    turned.push_back(copy);
  }
  return turned;
}

/// The street as a small sensor sees it, while it turns and others cross. Nothing in the method knows which
/// way is up, so every answer has to stay as it is when all is turned, shifted or put off. (From scan 45 on
/// none of its objects is just at a threshold, where rounding decides of a whole object.)
class Isotropy : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    street_ = new test::ToyScene(test::toy_street("VLP-16"));
    scans_ = new Scans(test::scans_of(test::cast_scans(*street_, 45, 14)));
    reference_ = new std::vector<Detection>(detect(*scans_, *street_->trajectory));
  }
  static void TearDownTestSuite() {
    delete reference_;
    delete scans_;
    delete street_;
  }
  static std::vector<Detection> detect(const Scans& scans, const Trajectory& trajectory) {
    return test::detect_all(scans, trajectory, {});
  }
  /// Returns whose traces differ, of all; and that there was something to differ about.
  static double share_that_differs(const std::vector<Detection>& detections) {
    EXPECT_EQ(detections.size(), reference_->size());
    std::size_t all = 0, other = 0, dynamic = 0;
    for (std::size_t k = 0; k < detections.size(); ++k) {
      EXPECT_EQ(detections[k].trace.size(), (*reference_)[k].trace.size());
      for (std::size_t i = 0; i < detections[k].trace.size(); ++i) {
        ++all;
        other += detections[k].trace[i] == (*reference_)[k].trace[i] ? 0 : 1;
        dynamic += (*reference_)[k].dynamic(i) ? 1 : 0;
      }
    }
    EXPECT_GT(dynamic, 500u);
    return static_cast<double>(other) / static_cast<double>(all);
  }
  /// Returns that are dynamic in one of the two but not in the other, of those that are dynamic in either.
  /// The share of all returns is smaller.
  static double share_of_other_labels(const std::vector<Detection>& a, const std::vector<Detection>& b) {
    EXPECT_EQ(a.size(), b.size());
    std::size_t either = 0, one = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      for (std::size_t i = 0; i < a[k].trace.size(); ++i) {
        either += a[k].dynamic(i) || b[k].dynamic(i) ? 1 : 0;
        one += a[k].dynamic(i) != b[k].dynamic(i) ? 1 : 0;
      }
    }
    EXPECT_GT(either, 500u);
    return static_cast<double>(one) / static_cast<double>(either);
  }
  static void expect_same(const std::vector<Detection>& a, const std::vector<Detection>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].object, b[k].object) << "scan " << k;
      EXPECT_TRUE(a[k].trace == b[k].trace) << "scan " << k;
    }
  }

  static inline test::ToyScene* street_ = nullptr;
  static inline Scans* scans_ = nullptr;
  static inline std::vector<Detection>* reference_ = nullptr;
};

// Rounding may decide ties the other way: which of two rays is the nearest, and with it a range offset. One
// label in a thousand is free.
constexpr double kTies = 1e-3;

TEST_F(Isotropy, TurningTheWorldChangesNoLabel) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 4; ++i) {
    Vector6d xi;
    for (double& x : xi) x = 2 * normal(random);
    xi.head<3>() *= 20;
    SCOPED_TRACE(testing::Message() << "xi " << xi.transpose());
    const test::MovedTrajectory moved(street_->trajectory, SE3::exp(xi), Duration());
    EXPECT_LE(share_that_differs(detect(*scans_, moved)), kTies);
  }
}

TEST_F(Isotropy, MountingTheSensorTurnedChangesNoLabel) {
  for (const double angle : {0.7, std::numbers::pi, -1.9}) {
    SCOPED_TRACE(angle);
    // Coordinates are rounded to float anew here, by up to 4 micrometres at 60 m.
    EXPECT_LE(
        share_that_differs(detect(in_turned_frame(*scans_, angle), TurnedSensor(street_->trajectory, angle))),
        kTies);
  }
}

// Frames of the world are arbitrary; the frame of a sensor has its z on the axis of rotation.
TEST_F(Isotropy, TurningSensorFrameAndWorldKeepsTheLabelsOfBothMethods) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (const char* profile : {"default", "paper"}) {
    const DetectorParameters parameters = detector_profile(profile);
    const auto expected = test::detect_all(*scans_, *street_->trajectory, parameters);
    const Eigen::Vector3d phi = 2 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const double angle = 3 * normal(random);
    SCOPED_TRACE(testing::Message() << profile << ", world " << phi.transpose() << ", sensor " << angle);
    const TurnedSensor turned(
        std::make_shared<test::MovedTrajectory>(street_->trajectory,
                                                SE3(so3_exp(phi), Eigen::Vector3d::Zero()), Duration()),
        angle);
    const auto detections = test::detect_all(in_turned_frame(*scans_, angle), turned, parameters);
    EXPECT_LE(share_of_other_labels(detections, expected), 1e-3);
  }
}

TEST_F(Isotropy, PuttingAllOffChangesNothing) {
  const Duration delay = Duration::from_nanoseconds(1'537'264'800'123'456'789);
  Scans later;
  for (const auto& scan : *scans_) {
    auto copy = std::make_shared<LidarScan>(*scan);
    copy->start = copy->start + delay;
    later.push_back(copy);
  }
  expect_same(detect(later, test::MovedTrajectory(street_->trajectory, SE3(), delay)), *reference_);
}

TEST_F(Isotropy, ThreadsDoNotMatter) {
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    expect_same(detect(*scans_, *street_->trajectory), *reference_);
  }
}

TEST_F(Isotropy, RunsRepeat) { expect_same(detect(*scans_, *street_->trajectory), *reference_); }

}  // namespace MAPLESS_FILE
}  // namespace mapless
