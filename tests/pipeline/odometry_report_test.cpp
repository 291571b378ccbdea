#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/pipeline/online_detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

// A scan of a tenth of a second.
LidarScan scan_at(double start_s) {
  LidarScan scan;
  scan.start = Time::from_seconds(start_s);
  scan.columns = 100;
  scan.column_period = Duration::from_seconds(0.001);
  return scan;
}

OdometryUpdate update_of(ScanOutcome outcome, MotionState state = MotionState::good) {
  OdometryUpdate update;
  update.outcome = outcome;
  update.state = state;
  return update;
}

TEST(OdometryReport, IsEmptyWhereAllIsWell) {
  OdometryReport report;
  report.add(scan_at(0), update_of(ScanOutcome::first));
  for (int k = 1; k < 5; ++k) report.add(scan_at(0.1 * k), update_of(ScanOutcome::registered));
  EXPECT_EQ(report.scans(), 5u);
  EXPECT_EQ(report.count(MotionState::good), 5u);
  EXPECT_EQ(report.trouble(), "");
  EXPECT_EQ(trouble_of(update_of(ScanOutcome::first)), "");
  EXPECT_EQ(trouble_of(update_of(ScanOutcome::registered)), "");
}

TEST(OdometryReport, CountsEachState) {
  OdometryReport report;
  report.add(scan_at(0.0), update_of(ScanOutcome::first));
  report.add(scan_at(0.1), update_of(ScanOutcome::registered, MotionState::degenerate));
  report.add(scan_at(0.2), update_of(ScanOutcome::repeated, MotionState::lost));
  report.add(scan_at(0.3), update_of(ScanOutcome::unsupported, MotionState::lost));
  report.add(scan_at(0.4), update_of(ScanOutcome::restarted));
  EXPECT_EQ(report.count(MotionState::good), 2u);
  EXPECT_EQ(report.count(MotionState::degenerate), 1u);
  EXPECT_EQ(report.count(MotionState::lost), 2u);
  EXPECT_EQ(report.restarts(), std::vector<std::size_t>{4});
  EXPECT_THAT(report.trouble(), HasSubstr("lost in 2 of 5 scans, the first of them scan 2"));
  EXPECT_THAT(report.trouble(), HasSubstr("begun anew at scan 4"));
}

TEST(OdometryReport, AStartUpDecidesTheStatesOfItsScans) {
  OdometryReport report;
  report.add(scan_at(0.0), update_of(ScanOutcome::few_points, MotionState::lost));
  report.add(scan_at(0.1), update_of(ScanOutcome::first));
  report.add(scan_at(0.2), update_of(ScanOutcome::unmatched, MotionState::lost));
  OdometryUpdate deciding = update_of(ScanOutcome::registered, MotionState::degenerate);
  deciding.decided_scans = 3;
  report.add(scan_at(0.3), deciding);
  EXPECT_EQ(report.count(MotionState::lost), 1u);
  EXPECT_EQ(report.count(MotionState::degenerate), 3u);
  EXPECT_THAT(report.trouble(), HasSubstr("lost in 1 of 4 scans, the first of them scan 0"));
}

// The start-up after a loss decides its own scans, not those before the restart.
TEST(OdometryReport, AStartUpAfterALossDecidesTheScansSinceTheRestart) {
  OdometryReport report;
  report.add(scan_at(0.0), update_of(ScanOutcome::first, MotionState::degenerate));
  OdometryUpdate deciding = update_of(ScanOutcome::registered);
  deciding.decided_scans = 2;
  report.add(scan_at(0.1), deciding);
  report.add(scan_at(0.2), update_of(ScanOutcome::unmatched, MotionState::lost));
  report.add(scan_at(0.3), update_of(ScanOutcome::restarted, MotionState::lost));
  report.add(scan_at(0.4), update_of(ScanOutcome::unmatched, MotionState::lost));
  EXPECT_EQ(report.count(MotionState::lost), 3u);
  report.add(scan_at(0.5), deciding);
  EXPECT_EQ(report.count(MotionState::good), 4u);
  EXPECT_EQ(report.count(MotionState::lost), 2u);
  EXPECT_THAT(report.trouble(), HasSubstr("lost in 2 of 6 scans, the first of them scan 2"));
}

// The first of these scans is final, and the rest are decided.
TEST(OdometryReport, AStartUpDecidesItsLastScansAtMost) {
  OdometryReport report;
  for (std::size_t k = 0; k < kMostStartUpScans; ++k)
    report.add(scan_at(0.1 * static_cast<double>(k)), update_of(ScanOutcome::few_points, MotionState::lost));
  OdometryUpdate deciding = update_of(ScanOutcome::registered);
  deciding.decided_scans = kMostStartUpScans;
  report.add(scan_at(100), deciding);
  EXPECT_EQ(report.count(MotionState::lost), 1u);
  EXPECT_EQ(report.count(MotionState::good), kMostStartUpScans);
}

// One line, however often the sensor was lost.
TEST(OdometryReport, NamesTheFirstRestarts) {
  OdometryReport report;
  for (int k = 0; k < 1000; ++k) report.add(scan_at(0.1 * k), update_of(ScanOutcome::restarted));
  EXPECT_THAT(report.trouble(),
              HasSubstr("begun anew at scan 0, 1, 2, 3, 4, 5, 6, 7 of the run, and 992 times more"));
}

// A scan may begin up to half its duration late; the one after it is missing where it begins later.
TEST(OdometryReport, CountsMissingScans) {
  OdometryReport report;
  for (const double start_s : {0.0, 0.1, 0.24, 0.40, 0.50})
    report.add(scan_at(start_s), update_of(ScanOutcome::registered));
  EXPECT_EQ(report.gaps(), 1u);
  EXPECT_THAT(report.trouble(), HasSubstr("scans are missing at 1 place"));
}

TEST(OdometryReport, EveryProblemOfAScanHasWords) {
  for (const ScanOutcome outcome : {ScanOutcome::first, ScanOutcome::few_points, ScanOutcome::repeated,
                                    ScanOutcome::unmatched, ScanOutcome::unsupported})
    EXPECT_NE(trouble_of(update_of(outcome, MotionState::lost)), "");
  EXPECT_THAT(trouble_of(update_of(ScanOutcome::registered, MotionState::degenerate)),
              HasSubstr("a direction is open"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
