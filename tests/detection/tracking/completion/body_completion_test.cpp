#include "detection/tracking/completion/body_completion.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

constexpr int kSeenThroughOnce = kSeenThroughVotes;

// A dynamic object of two points, 4 m apart along x, and one more point.
struct Scan {
  LocalPoints points;
  std::vector<PointEvidence> votes = std::vector<PointEvidence>(3);
  std::vector<TrackMotion> motions = std::vector<TrackMotion>(2);
  std::vector<TrackedObject> tracked = std::vector<TrackedObject>(2);  // at 5 m/s, known to 1 m/s
  std::vector<std::uint16_t> object = {1, 1, 0};

  Scan(float length_m, const Eigen::Vector3f& point, int votes_of_point) {
    points.points = {{0, 0, 0}, {length_m, 0, 0}, point};
    motions[0].moves = true;
    for (std::uint16_t number = 1; number <= 2; ++number) {
      TrackedObject& one = tracked[number - 1U];
      one.number = number;
      one.velocity_0 = {5, 0, 0};
      one.velocity_covariance_0 = Eigen::Matrix3d::Identity();
    }
    votes[2].past = static_cast<std::int16_t>(votes_of_point);
  }
  std::uint16_t number_of_point() {
    const auto taken = complete_bodies(points, votes, tracked, motions, object);
    EXPECT_EQ(taken.size(), object[2] == 1 ? 1u : 0u);
    return object[2];
  }
};

std::uint16_t number_of(float length_m, const Eigen::Vector3f& point, int votes = kSeenThroughOnce) {
  return Scan(length_m, point, votes).number_of_point();
}

TEST(CompleteBodies, TakesPointsWithinTheRadiusThatOneScanSawThrough) {
  EXPECT_EQ(number_of(2, {2.99F, 0, 0}), 1);
  EXPECT_EQ(number_of(2, {3.01F, 0, 0}), 0);
  EXPECT_EQ(number_of(2, {2, 0.99F, 0}), 1);
  EXPECT_EQ(number_of(2, {0, 0, -1.01F}), 0);
  EXPECT_EQ(number_of(2, {0.9F, 0, 0}, kSeenThroughOnce - 1), 0);
}

TEST(CompleteBodies, ReachesOneAndAHalfMetresAtMost) {
  EXPECT_EQ(number_of(10, {11.49F, 0, 0}), 1);
  EXPECT_EQ(number_of(10, {11.51F, 0, 0}), 0);
}

TEST(CompleteBodies, LeavesWhatIsKnownToBeSlow) {
  for (const bool slow : {false, true}) {
    Scan scan(4, {5, 0, 0}, kSeenThroughOnce);
    scan.object[2] = 2;
    scan.motions[1].slow = slow;
    EXPECT_EQ(complete_bodies(scan.points, scan.votes, scan.tracked, scan.motions, scan.object).size(),
              slow ? 0u : 1u);
    EXPECT_EQ(scan.object[2], slow ? 2 : 1);
  }
}

TEST(CompleteBodies, AStaticObjectTakesNothing) {
  Scan scan(4, {5, 0, 0}, kSeenThroughOnce);
  scan.motions[0].moves = false;
  EXPECT_EQ(scan.number_of_point(), 0);
}

TEST(CompleteBodies, AnObjectWhoseVelocityMayBeZeroTakesNothing) {
  for (const double std_mps : {1.6, 1.7}) {
    Scan scan(4, {5, 0, 0}, kSeenThroughOnce);
    scan.tracked[0].velocity_covariance_0(1, 1) = std_mps * std_mps;
    EXPECT_EQ(scan.number_of_point(), 3 * std_mps < 5 ? 1 : 0);
  }
}

TEST(CompleteBodies, ThePointIsOfTheNearerBody) {
  Scan scan(4, {5.2F, 0, 0}, kSeenThroughOnce);  // the other body is from 6 to 8 m
  scan.points.points.insert(scan.points.points.end(), {{6, 0, 0}, {8, 0, 0}});
  scan.votes.resize(5);
  scan.motions[1].moves = true;
  scan.object.insert(scan.object.end(), {2, 2});
  complete_bodies(scan.points, scan.votes, scan.tracked, scan.motions, scan.object);
  EXPECT_EQ(scan.object, (std::vector<std::uint16_t>{1, 1, 2, 2, 2}));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
