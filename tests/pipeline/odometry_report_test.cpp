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

OdometryUpdate update_of(ScanOutcome outcome) {
  OdometryUpdate update;
  update.outcome = outcome;
  update.converged = outcome == ScanOutcome::registered;
  return update;
}

TEST(OdometryReport, IsEmptyWhereAllIsWell) {
  OdometryReport report;
  report.add(scan_at(0), update_of(ScanOutcome::first));
  for (int k = 1; k < 5; ++k) report.add(scan_at(0.1 * k), update_of(ScanOutcome::registered));
  EXPECT_EQ(report.scans, 5u);
  EXPECT_EQ(report.trouble(), "");
  EXPECT_EQ(trouble_of(update_of(ScanOutcome::first)), "");
  EXPECT_EQ(trouble_of(update_of(ScanOutcome::registered)), "");
}

TEST(OdometryReport, CountsEachOutcome) {
  OdometryReport report;
  const ScanOutcome outcomes[] = {ScanOutcome::first,      ScanOutcome::registered, ScanOutcome::few_points,
                                  ScanOutcome::repeated,   ScanOutcome::lost,       ScanOutcome::restarted,
                                  ScanOutcome::registered, ScanOutcome::registered};
  int k = 0;
  for (const ScanOutcome outcome : outcomes) {
    OdometryUpdate update = update_of(outcome);
    if (k == 6) update.converged = false;
    if (k == 7) update.degeneracy.unconstrained = 1;
    report.add(scan_at(0.1 * k++), update);
  }
  EXPECT_EQ(report.scans, 8u);
  EXPECT_EQ(report.extrapolated, 4u);
  EXPECT_EQ(report.first_extrapolated, 2u);
  EXPECT_EQ(report.few_points, 1u);
  EXPECT_EQ(report.repeated, 1u);
  EXPECT_EQ(report.lost, 2u);
  EXPECT_EQ(report.restarts, 1u);
  EXPECT_EQ(report.not_converged, 1u);
  EXPECT_EQ(report.degenerate, 1u);
  EXPECT_EQ(report.gaps, 0u);
  EXPECT_THAT(report.trouble(), HasSubstr("4 of 8 scans could not be registered, the first of them scan 2"));
}

// A scan may begin up to half its duration late; the one after it is missing where it begins later.
TEST(OdometryReport, CountsMissingScans) {
  OdometryReport report;
  for (const double start_s : {0.0, 0.1, 0.24, 0.40, 0.50})
    report.add(scan_at(start_s), update_of(ScanOutcome::registered));
  EXPECT_EQ(report.gaps, 1u);
  EXPECT_THAT(report.trouble(), HasSubstr("scans are missing at 1 place"));
}

TEST(OdometryReport, EveryProblemOfAScanHasWords) {
  for (const ScanOutcome outcome :
       {ScanOutcome::few_points, ScanOutcome::repeated, ScanOutcome::lost, ScanOutcome::restarted})
    EXPECT_NE(trouble_of(update_of(outcome)), "");
  OdometryUpdate update = update_of(ScanOutcome::registered);
  update.degeneracy.unconstrained = 2;
  EXPECT_THAT(trouble_of(update), HasSubstr("2 of 3 directions"));
  update.converged = false;
  EXPECT_THAT(trouble_of(update), HasSubstr("converge"));
  update.ambiguous = true;
  EXPECT_THAT(trouble_of(update), HasSubstr("speed is uncertain"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
