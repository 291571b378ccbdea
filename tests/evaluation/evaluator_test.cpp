#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();

/// One scan, put together point by point.
struct Points {
  std::vector<std::uint32_t> truth, result;
  std::vector<float> ranges_m;

  /// `count` points of one true object, called dynamic as `result_object` where `called`.
  Points& add(int count, std::uint32_t truth_class, std::uint32_t id, bool called, float range_m,
              std::uint32_t result_object = 1) {
    for (int i = 0; i < count; ++i) {
      truth.push_back(truth_class | id << 16);
      result.push_back(called ? kLabelDynamic | result_object << 16 : kLabelStatic);
      ranges_m.push_back(range_m);
    }
    return *this;
  }
  [[nodiscard]] ScanLabels scan(std::size_t number = 0) const { return {number, truth, result, ranges_m}; }
};

EvaluationReport report_of(const Points& points, const ObjectTruth& objects = {},
                           std::optional<double> max_range_m = {}) {
  Evaluator evaluator(objects, max_range_m);
  evaluator.add(points.scan());
  return evaluator.report();
}

ObjectState moving_at(double speed_mps) {
  ObjectState state{};
  state.velocity_0 = {speed_mps, 0, 0};
  state.speed_mps = speed_mps;
  return state;
}

/// Cars 1 (speed 3 m/s) and 2 (parked), person 3 (0.4 m/s).
ObjectTruth street() {
  ObjectTruth truth;
  truth.has_descriptions = truth.has_states = true;
  truth.descriptions = {{1, {"car", "mover"}}, {2, {"car", "parked"}}, {3, {"person", "mover"}}};
  truth.states = {{{0, 1}, moving_at(3)}, {{0, 3}, moving_at(0.4)}};
  return truth;
}

const ClassReport& of_class(const EvaluationReport& report, std::string_view name) {
  for (const ClassReport& c : report.by_class) {
    if (c.object_class == name) return c;
  }
  throw std::out_of_range(std::string(name));
}

TEST(Evaluator, CountsEachPointOnceAndLeavesOutUnknownTruth) {
  Points points;
  points.add(3, kLabelDynamic, 1, true, 5).add(1, kLabelDynamic, 1, false, 5);
  points.add(2, kLabelStatic, 0, true, 5).add(4, kLabelStatic, 0, false, 5);
  points.add(7, kLabelUnknown, 0, true, 5).add(7, 1, 9, true, 5);
  const EvaluationReport report = report_of(points);
  EXPECT_EQ(report.points.total(), (Counts{.tp = 3, .fp = 2, .fn = 1, .tn = 4}));
  EXPECT_EQ(report.points.scans(), 1);
  EXPECT_EQ(report.objects, (Found{1, 1}));
  EXPECT_EQ(report.false_objects.objects, 1);
}

TEST(Evaluator, ABandIncludesItsUpperEdge) {
  Points points;
  points.add(1, kLabelDynamic, 1, true, 10).add(2, kLabelDynamic, 1, false, 10.01F);
  points.add(3, kLabelStatic, 0, false, 120).add(4, kLabelStatic, 0, true, 121);
  points.add(5, kLabelDynamic, 1, true, kNoReturn);
  const EvaluationReport report = report_of(points);
  ASSERT_EQ(report.by_range.size(), 7u);
  EXPECT_EQ(report.by_range[0].counts, (Counts{.tp = 1}));
  EXPECT_EQ(report.by_range[1].counts, (Counts{.fn = 2}));
  EXPECT_EQ(report.by_range[5].counts, (Counts{.tn = 3}));
  EXPECT_EQ(report.by_range[6].counts, (Counts{.fp = 4}));
  EXPECT_EQ(report.by_range[6].above, 120);
  EXPECT_EQ(report.points.total().points(), 15) << "those without a return count where range does not matter";
}

TEST(Evaluator, RecallWithinALimitCountsAllNearerPoints) {
  Evaluator evaluator(ObjectTruth{});
  Points near;
  near.add(1, kLabelDynamic, 1, true, 4.9F)
      .add(1, kLabelDynamic, 1, false, 5)
      .add(2, kLabelStatic, 0, true, 9);
  Points far;
  far.add(3, kLabelDynamic, 1, true, 9).add(1, kLabelDynamic, 1, false, 200);
  evaluator.add(near.scan(0));
  evaluator.add(far.scan(1));
  const EvaluationReport report = evaluator.report();
  ASSERT_EQ(report.within_range.size(), 24u);
  const RangeLimitReport& five = report.within_range[0];
  EXPECT_EQ(five.limit_m, 5);
  EXPECT_EQ(five.points.total(), (Counts{.tp = 1, .fn = 1}));
  EXPECT_EQ(five.points.scans(), 2);
  EXPECT_EQ(five.points.recall_scans(), 1);
  const RangeLimitReport& ten = report.within_range[1];
  EXPECT_EQ(ten.points.total(), (Counts{.tp = 4, .fp = 2, .fn = 1}));
  EXPECT_DOUBLE_EQ(ten.points.average_recall().value(), (0.5 + 1) / 2);
  EXPECT_EQ(report.within_range[23].limit_m, 120);
  EXPECT_EQ(report.within_range[23].points.total().fn, 1) << "the one at 200 m is in no limit";
}

TEST(Evaluator, AnObjectIsFoundWithHalfOfItsDynamicPoints) {
  Points points;
  points.add(2, kLabelDynamic, 1, true, 5).add(2, kLabelDynamic, 1, false, 5);
  points.add(1, kLabelDynamic, 2, true, 5).add(2, kLabelDynamic, 2, false, 5);
  // Static points of a mover, a planted foot, neither help nor harm; an object without dynamic points and
  // points of no object are none to be found.
  points.add(1, kLabelDynamic, 3, true, 5).add(8, kLabelStatic, 3, false, 5);
  points.add(4, kLabelStatic, 4, true, 5).add(4, kLabelDynamic, 0, true, 5);
  EXPECT_EQ(report_of(points).objects, (Found{2, 3}));
}

TEST(Evaluator, SplitsByClassAndKind) {
  Points points;
  points.add(6, kLabelDynamic, 1, true, 5)
      .add(2, kLabelDynamic, 1, false, 5)
      .add(1, kLabelStatic, 1, true, 5);
  points.add(3, kLabelStatic, 2, true, 5).add(5, kLabelStatic, 2, false, 5);
  points.add(1, kLabelDynamic, 3, false, 5);
  points.add(4, kLabelStatic, 0, true, 5).add(9, kLabelStatic, 0, false, 5);
  points.add(1, kLabelDynamic, 77, true, 5);
  const EvaluationReport report = report_of(points, street());
  ASSERT_EQ(report.by_class.size(), 4u);
  EXPECT_EQ(of_class(report, "car").points, (Counts{.tp = 6, .fp = 4, .fn = 2, .tn = 5}));
  EXPECT_EQ(of_class(report, "car").objects, (Found{1, 1}));
  EXPECT_EQ(of_class(report, "person").points, (Counts{.fn = 1}));
  EXPECT_EQ(of_class(report, "person").objects, (Found{0, 1}));
  EXPECT_FALSE(of_class(report, "person").points.precision());
  EXPECT_EQ(of_class(report, kNoObject).points, (Counts{.fp = 4, .tn = 9}));
  EXPECT_EQ(of_class(report, kNoObject).objects, Found{});
  EXPECT_FALSE(of_class(report, kNoObject).points.recall());
  EXPECT_EQ(of_class(report, kUnlisted).points, (Counts{.tp = 1}));
  ASSERT_EQ(report.by_kind.size(), 5u);
  EXPECT_EQ(report.by_kind[2].kind, "mover");
  EXPECT_EQ(report.by_kind[2].points, (Counts{.tp = 6, .fp = 1, .fn = 2}));
  EXPECT_EQ(report.by_kind[3].kind, "parked");
  EXPECT_EQ(report.by_kind[3].points, (Counts{.fp = 3, .tn = 5}));
}

TEST(Evaluator, RecallBySpeedIsOfDynamicPointsWhoseObjectHasAState) {
  ObjectTruth truth;
  truth.has_states = true;
  truth.states = {{{0, 1}, moving_at(0)},
                  {{0, 2}, moving_at(0.5)},
                  {{0, 3}, moving_at(30)},
                  {{1, 4}, moving_at(3)}};  // of another scan
  Points points;
  points.add(1, kLabelDynamic, 1, true, 5)
      .add(2, kLabelDynamic, 2, true, 5)
      .add(1, kLabelDynamic, 2, false, 5);
  points.add(5, kLabelDynamic, 3, false, 5)
      .add(6, kLabelStatic, 3, true, 5)
      .add(9, kLabelDynamic, 4, true, 5);
  const EvaluationReport report = report_of(points, truth);
  ASSERT_EQ(report.by_speed.size(), 7u);
  EXPECT_EQ(report.by_speed[0].counts, (Found{1, 1}));
  EXPECT_EQ(report.by_speed[1].counts, (Found{2, 3}));
  EXPECT_EQ(report.by_speed[1].up_to, 0.5);
  EXPECT_EQ(report.by_speed[6].counts, (Found{0, 5}));
  std::int64_t all = 0;
  for (const Band<Found>& band : report.by_speed) all += band.counts.of;
  EXPECT_EQ(all, 9);
}

TEST(Evaluator, RecallByVisiblePointsCountsStaticPointsOfTheObjectAsVisible) {
  Points points;
  points.add(4, kLabelDynamic, 1, true, 5);
  points.add(4, kLabelDynamic, 2, false, 5).add(1, kLabelStatic, 2, false, 5);
  points.add(300, kLabelDynamic, 3, true, 5).add(50, kLabelDynamic, 0, true, 5);
  const EvaluationReport report = report_of(points);
  ASSERT_EQ(report.by_visible_points.size(), 6u);
  EXPECT_EQ(report.by_visible_points[0].counts, (Found{4, 4}));
  EXPECT_EQ(report.by_visible_points[1].counts, (Found{0, 4}));
  EXPECT_EQ(report.by_visible_points[5].counts, (Found{300, 300}));
}

/// 20 points of car 1 (3 m/s), half of them found, at these two mean ranges of ten points each.
Found evident(int points, float range_m, float other_range_m, double speed_mps) {
  ObjectTruth truth = street();
  truth.states[{0, 1}] = moving_at(speed_mps);
  Points scan;
  scan.add(10, kLabelDynamic, 1, true, range_m).add(points - 10, kLabelDynamic, 1, false, other_range_m);
  return report_of(scan, truth).evident_movers.value();
}

TEST(Evaluator, EvidentMoversAreFastLargeAndNear) {
  EXPECT_EQ(evident(20, 10, 10, 3), (Found{1, 1}));
  EXPECT_EQ(evident(21, 10, 10, 3), (Found{0, 1})) << "10 of 21 are less than half";
  EXPECT_EQ(evident(19, 10, 10, 3), Found{});
  EXPECT_EQ(evident(20, 40, 60, 3), (Found{1, 1})) << "their mean is 50";
  EXPECT_EQ(evident(20, 40, 61, 3), Found{});
  EXPECT_EQ(evident(20, 10, 10, 0.5), Found{});
  EXPECT_EQ(evident(20, 10, 10, 0.51), (Found{1, 1}));
}

TEST(Evaluator, AFalseObjectHasMoreStaticThanDynamicPoints) {
  Points points;
  points.add(2, kLabelDynamic, 5, true, 5, 1).add(3, kLabelStatic, 0, true, 5, 1);
  points.add(2, kLabelDynamic, 5, true, 5, 2).add(2, kLabelStatic, 0, true, 5, 2);
  points.add(9, kLabelUnknown, 0, true, 5, 3).add(1, kLabelStatic, 0, true, 5, 4);
  points.add(6, kLabelUnknown, 0, true, 5, 4);
  Evaluator evaluator(ObjectTruth{});
  evaluator.add(points.scan(0));
  evaluator.add(points.scan(1));
  const FalseObjects found = evaluator.report().false_objects;
  EXPECT_EQ(found.objects, 6) << "1, 2 and 4 of each scan; all of 3 is unknown";
  EXPECT_EQ(found.false_ones, 4);
  EXPECT_EQ(found.per_scan(), 2.0);
}

TEST(Evaluator, FalseObjectsAreAbsentWithoutObjectNumbers) {
  Points points;
  points.add(3, kLabelStatic, 0, true, 5, 0);
  const FalseObjects found = report_of(points).false_objects;
  EXPECT_EQ(found.unnumbered_points, 3);
  EXPECT_FALSE(found.per_scan());
  EXPECT_EQ(report_of(Points().add(3, kLabelStatic, 0, false, 5)).false_objects.per_scan(), 0.0);
}

TEST(Evaluator, RatesWithoutTablesAreAbsent) {
  const EvaluationReport empty = Evaluator(ObjectTruth{}).report();
  EXPECT_FALSE(empty.objects.share());
  EXPECT_FALSE(empty.evident_movers);
  EXPECT_FALSE(empty.false_objects.per_scan());
  EXPECT_TRUE(empty.by_class.empty());
  EXPECT_TRUE(empty.by_kind.empty());
  EXPECT_TRUE(empty.by_speed.empty());
  ObjectTruth classes = street();
  classes.has_states = false;
  classes.states.clear();
  const EvaluationReport report = report_of(Points().add(30, kLabelDynamic, 1, true, 5), classes);
  EXPECT_EQ(of_class(report, "car").objects, (Found{1, 1}));
  EXPECT_FALSE(of_class(report, "car").evident_movers);
  EXPECT_FALSE(report.evident_movers);
}

TEST(Evaluator, PointsBeyondTheLimitDoNotCount) {
  Points points;
  points.add(10, kLabelDynamic, 1, true, 20).add(15, kLabelDynamic, 1, false, 20.01F);
  points.add(2, kLabelStatic, 0, true, 30, 4).add(1, kLabelStatic, 0, true, kNoReturn, 5);
  const EvaluationReport report = report_of(points, street(), 20.0);
  EXPECT_EQ(report.points.total(), (Counts{.tp = 10}));
  EXPECT_EQ(report.objects, (Found{1, 1}));
  EXPECT_EQ(report.by_visible_points[2].counts, (Found{10, 10}));
  EXPECT_EQ(report.false_objects.objects, 1);
  EXPECT_EQ(report.evident_movers, Found{});
}

TEST(Evaluator, RefusesScansOfUnequalLength) {
  Points points;
  points.add(2, kLabelStatic, 0, false, 5);
  Evaluator evaluator(ObjectTruth{});
  points.ranges_m.pop_back();
  EXPECT_THROW(evaluator.add(points.scan()), InputError);
  points.truth.pop_back();
  EXPECT_THROW(evaluator.add(points.scan()), InputError);
}

TEST(Evaluator, TakesTheRangeOfEachRecordFromItsReturn) {
  LidarScan scan;
  scan.input_size = 3;
  scan.returns.push_back({{1, 0, 0}, 7.5F, 0, 0, 0, 2});
  const std::vector<float> ranges = ranges_of(scan);
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_TRUE(std::isnan(ranges[0]) && std::isnan(ranges[1]));
  EXPECT_EQ(ranges[2], 7.5F);
}

TEST(Evaluator, RefusesARangeLimitThatIsNotPositive) {
  for (const double limit_m : {0.0, -1.0, std::nan(""), 2e6}) {
    SCOPED_TRACE(limit_m);
    EXPECT_THROW(Evaluator(ObjectTruth{}, limit_m), ParameterError);
    EXPECT_THROW(VelocityEvaluator(ObjectTruth{}, {}, "objects.csv", limit_m), ParameterError);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
