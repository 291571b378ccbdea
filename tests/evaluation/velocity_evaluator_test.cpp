#include <cmath>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// One scan, put together point by point. All points lie 10 m away.
struct Points {
  std::vector<std::uint32_t> truth, result;
  std::vector<float> ranges_m;

  // `count` points of a true object (0: static points), labelled dynamic as object `number` (0: static).
  Points& add(int count, std::uint32_t id, std::uint32_t number, float range_m = 10) {
    for (int i = 0; i < count; ++i) {
      truth.push_back(id != 0 ? kLabelDynamic | id << 16 : kLabelStatic);
      result.push_back(number != 0 ? kLabelDynamic | number << 16 : kLabelStatic);
      ranges_m.push_back(range_m);
    }
    return *this;
  }
  [[nodiscard]] ScanLabels scan(std::size_t number) const { return {number, truth, result, ranges_m}; }
};

ObjectState moving(const Vector3d& velocity) {
  return {Time::from_seconds(0), Vector3d::Zero(), velocity, velocity.norm()};
}

ObjectRow row(std::size_t scan, std::uint32_t id, const Vector3d& velocity, int age = 5) {
  return {scan, Time::from_seconds(0), id, 9, {0, 0, 0}, {1, 1, 1}, velocity, {0.1, 0.2, 0.4}, age};
}

// Mover 1 has 5 m/s along x in scans 0 to 2, mover 2 0.9 m/s.
ObjectTruth street() {
  ObjectTruth truth;
  truth.has_states = true;
  for (std::size_t k = 0; k < 3; ++k) {
    truth.states[{k, 1}] = moving({5, 0, 0});
    truth.states[{k, 2}] = moving({0.9, 0, 0});
  }
  return truth;
}

VelocityReport report_of(const std::vector<Points>& scans, const std::vector<ObjectRow>& rows,
                         std::optional<double> max_range_m = {}) {
  VelocityEvaluator evaluator(street(), rows, "objects.csv", max_range_m);
  for (std::size_t k = 0; k < scans.size(); ++k) evaluator.add(scans[k].scan(k), Matrix3d::Identity());
  return evaluator.report();
}

TEST(VelocityEvaluator, ErrorsAreLengthsOfDifferences) {
  const auto scans = std::vector(3, Points().add(4, 1, 7));
  const VelocityReport r =
      report_of(scans, {row(0, 7, {5.1, 0, 0}), row(1, 7, {5, 0.2, 0}), row(2, 7, {5, 0.3, 0.4})});
  EXPECT_EQ(r.evaluated, 3);
  EXPECT_NEAR(r.rms_mps.value(), std::sqrt((0.01 + 0.04 + 0.25) / 3), 1e-12);
  EXPECT_NEAR(r.median_mps.value(), 0.2, 1e-12);
  EXPECT_NEAR(r.small_error_share.value(), 2.0 / 3, 1e-12);
  // Over (0.1, 0.2, 0.4): 1; 1; 1.5 and 1.
  EXPECT_NEAR(r.normalised_rms.value(), std::sqrt((1 + 1 + 3.25) / 9), 1e-12);
  EXPECT_EQ(r.movers, 1);
  EXPECT_EQ(r.id_changes, 0);
}

TEST(VelocityEvaluator, ConfidentVelocitiesAreEvaluatedSeparately) {
  ObjectRow unsure = row(1, 7, {9, 0, 0});
  unsure.velocity_std_0.y() = kConfidentVelocityStd_mps;
  const VelocityReport r = report_of(std::vector(2, Points().add(4, 1, 7)), {row(0, 7, {5, 0, 0.3}), unsure});
  EXPECT_EQ(r.evaluated, 2);
  EXPECT_EQ(r.confident, 1);
  EXPECT_NEAR(r.confident_rms_mps.value(), 0.3, 1e-12);
}

TEST(VelocityEvaluator, AMoverIsMatchedWithTheObjectThatCoversMostOfIt) {
  const std::vector<ObjectRow> rows = {row(0, 3, {0, 0, 0}), row(0, 4, {5, 0, 0})};
  EXPECT_NEAR(report_of({Points().add(2, 1, 3).add(3, 1, 4)}, rows).rms_mps.value(), 0, 1e-12);
  EXPECT_NEAR(report_of({Points().add(2, 1, 3).add(2, 1, 4)}, rows).rms_mps.value(), 5, 1e-12)
      << "the lowest of equals";
}

TEST(VelocityEvaluator, EvaluatesFoundFastMoversWithTheirOwnObjectOnly) {
  const std::vector<ObjectRow> rows = {row(0, 3, {5, 0, 0}), row(1, 3, {5, 0, 0}, 1)};
  EXPECT_EQ(report_of({Points().add(1, 1, 3).add(2, 1, 0)}, rows).movers, 0) << "a third is found";
  EXPECT_EQ(report_of({Points().add(1, 1, 3).add(1, 1, 0)}, rows).evaluated, 1) << "half is found";
  const VelocityReport slow = report_of({Points().add(3, 2, 3)}, rows);
  EXPECT_EQ(slow.evaluated, 0);
  EXPECT_EQ(slow.movers, 1);
  EXPECT_FALSE(slow.rms_mps);
  const VelocityReport mixed = report_of({Points().add(3, 1, 3).add(3, 0, 3)}, rows);
  EXPECT_EQ(mixed.evaluated, 0);
  EXPECT_EQ(mixed.mixed, 1);
  const VelocityReport fresh = report_of({Points(), Points().add(3, 1, 3)}, rows);
  EXPECT_EQ(fresh.evaluated, 0);
  EXPECT_EQ(fresh.first_seen, 1);
}

TEST(VelocityEvaluator, CountsChangesOfId) {
  const std::vector<ObjectRow> rows = {row(0, 3, {5, 0, 0}), row(0, 8, {0, 0, 0}), row(1, 4, {5, 0, 0}),
                                       row(1, 8, {0, 0, 0}), row(2, 3, {5, 0, 0})};
  const VelocityReport r = report_of(
      {Points().add(3, 1, 3).add(2, 2, 8), Points().add(3, 1, 4).add(2, 2, 8), Points().add(3, 1, 3)}, rows);
  EXPECT_EQ(r.movers, 2);
  EXPECT_EQ(r.id_changes, 2) << "3 to 4, and back";
}

TEST(VelocityEvaluator, LeavesOutPointsBeyondTheLimit) {
  const std::vector<ObjectRow> rows = {row(0, 3, {0, 0, 0}), row(0, 4, {5, 0, 0})};
  const Points points = Points().add(5, 1, 3, 30).add(2, 1, 4, 10);
  EXPECT_NEAR(report_of({points}, rows, 20).rms_mps.value(), 0, 1e-12);
  EXPECT_NEAR(report_of({points}, rows).rms_mps.value(), 5, 1e-12);
}

TEST(VelocityEvaluator, FindsIdsBeyond65535ByTheirLabel) {
  EXPECT_NEAR(report_of({Points().add(3, 1, 7)}, {row(0, 65542, {5, 0, 0})}).rms_mps.value(), 0, 1e-12);
}

TEST(VelocityEvaluator, RefusesLabelsOfAnotherRun) {
  EXPECT_THROW(report_of({Points().add(3, 1, 7)}, {row(0, 8, {5, 0, 0})}), InputError);
  EXPECT_THROW(report_of({Points().add(3, 0, 7)}, {row(1, 7, {5, 0, 0})}), InputError);
}

TEST(VelocityEvaluator, RefusesScansOfDifferentLengths) {
  VelocityEvaluator evaluator({}, {}, "objects.csv");
  Points points;
  points.add(3, 1, 1);
  points.result.pop_back();
  EXPECT_THROW(evaluator.add(points.scan(0), Matrix3d::Identity()), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
