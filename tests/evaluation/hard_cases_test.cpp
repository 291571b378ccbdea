#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr std::uint32_t kCar = kLabelDynamic | 7u << 16, kParkedCar = kLabelStatic | 7u << 16;

/// One laser of 360 columns, one a degree: a hit per letter, the rest of the turn is the last letter.
/// W: static wall at 10 m, F: static fence at 4 m, C: dynamic car at 8 m, c: its static points, -: nothing
/// within range, x: faulty.
struct Row {
  LidarScan scan;
  std::vector<std::uint32_t> truth, result;
  std::vector<float> ranges_m;

  explicit Row(std::string letters) {
    letters.resize(360, letters.back());
    auto model = std::make_shared<LidarModel>();
    model->name = "one laser";
    model->columns = 360;
    model->max_range_m = 100;
    model->lasers.resize(1);
    scan.model = model;
    scan.columns = 360;
    scan.column_period = Duration::from_seconds(0.1 / 360);
    std::vector<LidarRecord> records;
    for (int c = 0; c < 360; ++c) {
      const char letter = letters[static_cast<std::size_t>(c)];
      const double range_m = letter == 'W' ? 10 : letter == 'F' ? 4 : 8;
      const ReturnCode code = letter == '-'   ? ReturnCode::nothing
                              : letter == 'x' ? ReturnCode::faulty
                                              : ReturnCode::hit;
      records.push_back({model->point_v(0, c, range_m).cast<float>(), 0, c, 0, code});
      truth.push_back(letter == 'C'             ? kCar
                      : letter == 'c'           ? kParkedCar
                      : code == ReturnCode::hit ? kLabelStatic
                                                : kLabelUnknown);
      result.push_back(kLabelStatic);
    }
    scan = organise(scan, records, "row");
    ranges_m = ranges_of(scan);
  }
  /// The column is labelled dynamic.
  Row& call(std::size_t column) {
    result[column] = kLabelDynamic;
    return *this;
  }
  [[nodiscard]] SightReport report(std::optional<double> max_range_m = {}) const {
    SightEvaluator evaluator(max_range_m);
    evaluator.add(scan, {0, truth, result, ranges_m});
    return evaluator.report();
  }
};

TEST(SightEvaluator, APointBetweenTwoSlatsIsSeenThroughAGap) {
  EXPECT_EQ(Row("WFCFW").call(2).report().through_gap, (Found{1, 1}));
  EXPECT_EQ(Row("WFCFW").report().through_gap, (Found{0, 1}));
  EXPECT_EQ(Row("WFCCFW").report().through_gap.of, 0) << "a gap of more than a column";
  EXPECT_EQ(Row("WFCW").report().through_gap.of, 0) << "beside one slat";
  EXPECT_EQ(Row("WWCWW").report().through_gap.of, 0) << "before a wall";
  EXPECT_EQ(Row("WFcFW").report().through_gap.of, 0) << "it does not move";
}

TEST(SightEvaluator, APointBetweenRaysThatHitNothingIsBeforeTheSky) {
  EXPECT_EQ(Row("-CCC-").call(1).call(3).report().before_sky, (Found{2, 3}));
  EXPECT_EQ(Row("-cCxC-").call(2).report().before_sky, (Found{1, 2}))
      << "the object's own points and faulty rays are passed over";
  EXPECT_EQ(Row("-CCCW-").report().before_sky.of, 0) << "a wall beside it";
  EXPECT_EQ(Row("-CWC-").report().before_sky.of, 0) << "a wall between";
  EXPECT_EQ(Row("WxCxW").report().before_sky.of, 0) << "faulty rays prove no sky";
}

TEST(SightEvaluator, TheSeamOfTheTurnIsNoBorder) {
  std::string letters(360, '-');
  letters.front() = letters.back() = 'C';
  EXPECT_EQ(Row(letters).call(0).report().before_sky, (Found{1, 2}));
  letters = std::string(360, 'W');
  letters[0] = 'C';
  letters[1] = letters[359] = 'F';
  EXPECT_EQ(Row(letters).report().through_gap.of, 1);
}

TEST(SightEvaluator, LeavesOutPointsBeyondTheLimitAndRefusesOtherLengths) {
  EXPECT_EQ(Row("-C-").report(7.9).before_sky.of, 0);
  EXPECT_EQ(Row("-C-").report(8.1).before_sky.of, 1);
  Row row("-C-");
  row.result.pop_back();
  EXPECT_THROW(static_cast<void>(row.report()), InputError);
}

/// A mover of 20 points: its speed in each scan [m/s], and how many of the points are labelled dynamic.
struct Drive {
  std::vector<double> speeds_mps;
  std::vector<int> called;

  Drive& add(int scans, double speed_mps, int called_points) {
    speeds_mps.insert(speeds_mps.end(), static_cast<std::size_t>(scans), speed_mps);
    called.insert(called.end(), static_cast<std::size_t>(scans), called_points);
    return *this;
  }
  [[nodiscard]] std::optional<DelayReport> report(bool has_states = true, std::size_t points = 20) const {
    ObjectTruth truth;
    truth.has_states = has_states;
    for (std::size_t k = 0; k < speeds_mps.size(); ++k) truth.states[{k, 7}].speed_mps = speeds_mps[k];
    DelayEvaluator evaluator(truth);
    for (std::size_t k = 0; k < speeds_mps.size(); ++k) {
      const std::vector<std::uint32_t> labels(points, speeds_mps[k] > 0.2 ? kCar : kParkedCar);
      std::vector<std::uint32_t> result(points, kLabelStatic);
      std::fill_n(result.begin(), std::min<std::size_t>(static_cast<std::size_t>(called[k]), points),
                  kLabelDynamic);
      evaluator.add({k, labels, result, std::vector<float>(points, 5)});
    }
    return evaluator.report();
  }
};

void expect_delay(const Delays& delays, std::int64_t events, std::int64_t never,
                  std::optional<double> median_scans) {
  EXPECT_EQ(delays.events, events);
  EXPECT_EQ(delays.never, never);
  EXPECT_EQ(delays.median_scans, median_scans);
}

TEST(DelayEvaluator, AStartIsNoticedWithHalfOfThePoints) {
  // Scan 6 is the first above 0.2 m/s; scan 9 the first with ten of twenty points.
  const auto report = Drive().add(6, 0, 0).add(2, 0.3, 9).add(1, 0.6, 9).add(9, 1, 10).report();
  expect_delay(report->start, 1, 0, 3);
  expect_delay(report->stop, 0, 0, std::nullopt);
}

TEST(DelayEvaluator, AnObjectThatCreepsOrWasMovingDoesNotStart) {
  EXPECT_EQ(Drive().add(6, 0, 0).add(30, 0.45, 20).report()->start.events, 0) << "never 0.5 m/s";
  EXPECT_EQ(Drive().add(4, 0.15, 0).add(2, 0, 0).add(9, 1, 20).report()->start.events, 0);
  EXPECT_EQ(Drive().add(4, 0, 0).add(9, 1, 20).report()->start.events, 0) << "seen for four scans before";
  EXPECT_EQ(Drive().add(6, 0, 0).add(9, 1, 20).report(true, 19)->start.events, 0) << "19 points";
}

TEST(DelayEvaluator, AStopIsNoticedWithUnderATenth) {
  // Scan 8 is the first below 0.1 m/s; 2 of 20 points are a tenth, in scans 8 to 10; scan 11 has one.
  const auto report = Drive().add(8, 1, 20).add(3, 0, 2).add(9, 0, 1).report();
  expect_delay(report->stop, 1, 0, 3);
  EXPECT_EQ(Drive().add(8, 1, 20).add(4, 0, 0).report()->stop.events, 0) << "seen for four scans only";
  EXPECT_EQ(Drive().add(8, 1, 20).add(5, 0, 0).add(5, 1, 20).report()->stop.events, 0) << "goes on";
  EXPECT_EQ(Drive().add(8, 0.5, 20).add(9, 0, 0).report()->stop.events, 0) << "only crept";
}

TEST(DelayEvaluator, WhatIsNotNoticedWithin25ScansIsNeverNoticed) {
  const auto late = Drive().add(6, 0, 0).add(25, 1, 0).add(9, 1, 20).report();
  expect_delay(late->start, 1, 1, std::nullopt);
  const auto just = Drive().add(6, 0, 0).add(24, 1, 0).add(9, 1, 20).report();
  expect_delay(just->start, 1, 0, 24);
}

TEST(DelayEvaluator, QuantilesCountWhatWasNeverNoticedAsLast) {
  // Two starts of one object: after 2 scans, and never.
  const auto report = Drive().add(6, 0, 0).add(2, 1, 0).add(9, 1, 20).add(9, 0, 0).add(25, 1, 0).report();
  expect_delay(report->start, 2, 1, 2);
  EXPECT_EQ(report->start.p90_scans, std::nullopt);
}

TEST(DelayEvaluator, WithoutTrueSpeedsThereIsNoReport) {
  EXPECT_EQ(Drive().add(6, 0, 0).add(9, 1, 20).report(false), std::nullopt);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
