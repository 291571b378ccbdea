#include "odometry/solver/growing_trajectory.hpp"

#include <thread>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// A knot every 0.1 s: 10 m/s along x, and a turn that differs from knot to knot.
std::vector<TrajectoryKnot> knots_of_drive(std::size_t count) {
  std::vector<TrajectoryKnot> out;
  SE3 T_v0;
  for (std::size_t k = 0; k < count; ++k) {
    Vector6d varpi;
    varpi << -10, 0, 0, 0, 0, 0.1 * static_cast<double>(k % 7);
    out.push_back({Time::from_nanoseconds(static_cast<std::int64_t>(k) * 100'000'000), T_v0, varpi});
    T_v0 = SE3::exp(0.1 * varpi) * T_v0;
  }
  return out;
}

void expect_equal(const TrajectoryState& a, const TrajectoryState& b) {
  EXPECT_EQ(a.T_v0.matrix(), b.T_v0.matrix());
  EXPECT_EQ(a.varpi, b.varpi);
}

// Drives shorter than a chunk, up to a knot of either side of one and of two of them.
TEST(GrowingTrajectory, ASnapshotEqualsTheTrajectoryOverTheSameKnots) {
  const std::size_t chunk = GrowingTrajectory::kKnots;
  for (const std::size_t count : {std::size_t{2}, chunk - 1, chunk, chunk + 1, 2 * chunk, 2 * chunk + 9}) {
    SCOPED_TRACE(count);
    const std::vector<TrajectoryKnot> knots = knots_of_drive(count);
    GrowingTrajectory chunks;
    for (std::size_t n = 0; n <= count; ++n) chunks.update(std::span(knots).first(n), n < 3 ? 0 : n - 3);
    const auto snapshot = chunks.snapshot(knots);
    const GaussianProcessTrajectory whole(knots, "test");
    ASSERT_EQ(snapshot->begin(), whole.begin());
    ASSERT_EQ(snapshot->end(), whole.end());
    // 50 ms steps: on the knots and between them, also on the knots that two chunks share.
    const Duration period = Duration::from_nanoseconds(50'000'000);
    std::vector<TrajectoryState> states(2 * count - 1), expected(2 * count - 1);
    snapshot->sample(whole.begin(), period, states);
    whole.sample(whole.begin(), period, expected);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Time t = whole.begin() + Duration::from_nanoseconds(static_cast<std::int64_t>(i) * 50'000'000);
      expect_equal(states[i], expected[i]);
      expect_equal(snapshot->at(t), expected[i]);
    }
    EXPECT_THROW((void)snapshot->at(whole.end() + Duration::from_nanoseconds(1)), TrajectoryDomainError);
  }
}

// As long as three chunks, all but the last three knots final. The first chunk ends with knot 256.
TEST(GrowingTrajectory, ForgetsWholeChunksThatEndBeforeATime) {
  const std::size_t chunk = GrowingTrajectory::kKnots;
  const std::vector<TrajectoryKnot> drive = knots_of_drive(3 * chunk + 9);
  std::vector<TrajectoryKnot> knots(drive.begin(), drive.end() - 100);
  GrowingTrajectory chunks;
  chunks.update(knots, knots.size() - 3);
  const auto before = chunks.snapshot(knots);
  EXPECT_EQ(chunks.forget_before(drive[chunk].time - Duration::from_nanoseconds(1)), 0u);
  ASSERT_EQ(chunks.forget_before(drive[chunk + 5].time), chunk);
  knots = {drive.begin() + static_cast<std::ptrdiff_t>(chunk), drive.end()};
  chunks.update(knots, knots.size() - 3);
  const auto snapshot = chunks.snapshot(knots);
  EXPECT_EQ(before->begin(), drive.front().time) << "a snapshot stays as it is";
  EXPECT_EQ(snapshot->begin(), drive[chunk].time);
  EXPECT_EQ(snapshot->end(), drive.back().time);
  const GaussianProcessTrajectory whole(drive, "test");
  for (const TrajectoryKnot& knot : knots) expect_equal(snapshot->at(knot.time), whole.at(knot.time));
  EXPECT_THROW((void)snapshot->at(drive[chunk - 1].time), TrajectoryDomainError);
  ASSERT_EQ(chunks.forget_before(drive.back().time), 2 * chunk) << "not the knots after the last full chunk";
}

TEST(GrowingTrajectory, OfLessThanTwoKnotsTheDomainIsEmpty) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}}) {
    const auto snapshot = GrowingTrajectory().snapshot(knots_of_drive(count));
    EXPECT_GT(snapshot->begin(), snapshot->end());
    EXPECT_THROW((void)snapshot->at(Time()), TrajectoryDomainError);
  }
}

// The last three knots are corrected by every scan, as the odometry does, while another thread reads
// snapshots.
TEST(GrowingTrajectory, ThreadsReadSnapshotsWhileTheTrajectoryGrows) {
  const std::vector<TrajectoryKnot> drive = knots_of_drive(GrowingTrajectory::kKnots + 40);
  std::vector<TrajectoryKnot> knots;
  GrowingTrajectory chunks;
  std::vector<std::thread> readers;
  for (std::size_t n = 0; n < drive.size(); ++n) {
    knots.push_back(drive[n]);
    for (std::size_t k = n < 3 ? 0 : n - 3; k < n; ++k) knots[k].varpi[0] -= 1;
    chunks.update(knots, n < 3 ? 0 : n - 3);
    if (n < 2 || n % 16 != 0) continue;
    readers.emplace_back([snapshot = chunks.snapshot(knots), expected = knots] {
      const GaussianProcessTrajectory whole(expected, "test");
      for (const TrajectoryKnot& knot : expected) expect_equal(snapshot->at(knot.time), whole.at(knot.time));
    });
  }
  for (std::thread& reader : readers) reader.join();
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
