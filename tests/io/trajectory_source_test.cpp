#include <array>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "support/memory_dataset.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::MemoryDataset;
using test::regular_starts;
using testing::AllOf;
using testing::HasSubstr;

// Ten scans of a tenth of a second; the sensor drives 1 m a scan along x.
class TrajectorySourceTest : public testing::Test {
 protected:
  std::filesystem::path kitti_file(int rows) {
    std::string text;
    for (int k = 0; k < rows; ++k) text += "1 0 0 " + std::to_string(k) + " 0 1 0 0 0 0 1 0\n";
    write_file_atomically(folder / "poses.txt", text);
    return folder / "poses.txt";
  }
  std::filesystem::path tum_file(double begin, double end) {
    std::string text = "# t tx ty tz qx qy qz qw\n";
    for (const double t : {begin, end}) {
      text += std::to_string(t) + " " + std::to_string(10 * t) + " 0 0 0 0 0 1\n";
    }
    write_file_atomically(folder / "tum.txt", text);
    return folder / "tum.txt";
  }
  double x_at(const TrajectorySource& source, double seconds) {
    return source.trajectory->at(Time::from_seconds(seconds)).T_v0.inverse().translation().x();
  }

  test::TemporaryFolder folder;
  MemoryDataset dataset{regular_starts(10), 10};
  TrajectoryRequest request;
};

TEST_F(TrajectorySourceTest, WithoutATrajectoryTheErrorNamesTheOptions) {
  try {
    (void)open_trajectory(dataset, request);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.detail().remedy, AllOf(HasSubstr("--trajectory"), HasSubstr("--stationary")));
  }
}

TEST_F(TrajectorySourceTest, ReadsAPipe) {
  const std::string text = read_whole_file(tum_file(0, 1));
  std::array<int, 2> ends{};
  for (const bool with_conventions : {true, false}) {
    ASSERT_EQ(pipe(ends.data()), 0);
    ASSERT_EQ(write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    close(ends[1]);
    request.file = "/dev/fd/" + std::to_string(ends[0]);
    if (with_conventions) {
      EXPECT_NEAR(x_at(open_trajectory(dataset, request), 0.5), 5, 1e-9);
    } else {
      EXPECT_EQ(read_trajectory(dataset, request).poses().size(), 2u);
    }
    close(ends[0]);
  }
}

TEST_F(TrajectorySourceTest, UsesTheTrajectoryOfTheRecordingByDefault) {
  dataset.own_trajectory = std::make_shared<StationaryTrajectory>();
  EXPECT_EQ(open_trajectory(dataset, request).conventions.front().second, "recording");
  request.stationary = true;
  EXPECT_EQ(open_trajectory(dataset, request).conventions.front().second, "stationary sensor");
  request.stationary = false;
  request.file = kitti_file(10);
  EXPECT_EQ(open_trajectory(dataset, request).conventions.front().second, request.file.string());
}

TEST_F(TrajectorySourceTest, AssignsEachRowToTheRequestedInstant) {
  request.file = kitti_file(10);
  EXPECT_NEAR(x_at(open_trajectory(dataset, request), 0.25), 2.0, 1e-9);
  request.instant = PoseInstant::start;
  EXPECT_NEAR(x_at(open_trajectory(dataset, request), 0.25), 2.5, 1e-9);
  request.instant = PoseInstant::end;
  EXPECT_NEAR(x_at(open_trajectory(dataset, request), 0.25), 1.5, 1e-9);
}

TEST_F(TrajectorySourceTest, OneRowPerScanIsExtrapolatedOverTheWholeRecording) {
  request.file = kitti_file(10);
  for (const PoseInstant instant : {PoseInstant::start, PoseInstant::middle, PoseInstant::end}) {
    request.instant = instant;
    const TrajectorySource source = open_trajectory(dataset, request);
    EXPECT_NO_THROW(require_coverage(dataset, *source.trajectory, 0, 10));
    EXPECT_NEAR(x_at(source, 1.0) - x_at(source, 0.0), 10, 1e-9);
  }
}

TEST_F(TrajectorySourceTest, AFileWithTimesIsNotExtrapolated) {
  request.file = tum_file(0.0, 0.95);
  const TrajectorySource source = open_trajectory(dataset, request);
  EXPECT_NO_THROW(require_coverage(dataset, *source.trajectory, 0, 9));
  EXPECT_NO_THROW(require_coverage(dataset, *source.trajectory, 8, 1));
  try {
    require_coverage(dataset, *source.trajectory, 5, 5);
    FAIL();
  } catch (const TrajectoryDomainError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("scan 9"), HasSubstr("0.9"), HasSubstr("0.95"),
                                    HasSubstr("--max-extrapolation-s")));
  }
  request.max_extrapolation_s = 0.05;
  EXPECT_NO_THROW(require_coverage(dataset, *open_trajectory(dataset, request).trajectory, 0, 10));
}

TEST_F(TrajectorySourceTest, ALateTrajectoryIsNamedAtTheFirstScan) {
  request.file = tum_file(0.05, 2.0);
  const TrajectorySource source = open_trajectory(dataset, request);
  EXPECT_THROW(require_coverage(dataset, *source.trajectory, 0, 1), TrajectoryDomainError);
  EXPECT_NO_THROW(require_coverage(dataset, *source.trajectory, 1, 9));
}

TEST_F(TrajectorySourceTest, FewerRowsThanScansAreRefused) {
  request.file = kitti_file(9);
  EXPECT_THROW((void)open_trajectory(dataset, request), InputError);
}

TEST_F(TrajectorySourceTest, CameraPosesNeedTheirCalibration) {
  request.file = kitti_file(10);
  request.frame = PoseFrame::camera;
  try {
    (void)open_trajectory(dataset, request);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.detail().remedy, HasSubstr("--calib"));
  }
}

TEST_F(TrajectorySourceTest, RefusesANegativeOrNonFiniteExtrapolation) {
  request.file = kitti_file(10);
  for (const double seconds :
       {-0.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    request.max_extrapolation_s = seconds;
    EXPECT_THROW((void)open_trajectory(dataset, request), ParameterError);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
