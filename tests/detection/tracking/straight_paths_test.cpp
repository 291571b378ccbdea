#include "detection/tracking/straight_paths.hpp"

#include <memory>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using Eigen::Vector3d;

constexpr int kScans = 12;

Time start_of(int k) { return Time() + Duration::from_seconds(0.1 * k); }

struct Scene {
  Vector3d sensor_mps = Vector3d::Zero();
  int points = 2;        // of each cluster, a vertical line of 0.1 m
  int rays_through = 0;  // each point
  bool body = false;     // an object, too: a cube of 1 m, its centre 1 m behind the first cluster
};

void add_point(const Vector3d& p, int rays_through, LidarScan& scan, ObjectProposals& proposed) {
  LidarReturn r;
  r.position_v.setZero();
  r.time_ns = r.column = r.laser = 0;
  r.input_index = 0;
  r.range_m = static_cast<float>(p.norm());
  scan.returns.push_back(r);
  proposed.points.points.push_back(p.cast<float>());
  PointEvidence votes;
  votes.rays_through = static_cast<std::uint8_t>(rays_through);
  proposed.votes.push_back(votes);
  proposed.object.push_back(0);
}

// Faint clusters of scan `k` of a VLP-16.
ObjectProposals faint_clusters(int k, const std::vector<Vector3d>& places_0, const Scene& scene) {
  static const auto model = test::toy_room("VLP-16", test::drive(0, 0)).model;
  auto scan = std::make_shared<LidarScan>();
  scan->model = model;
  scan->start = start_of(k);
  ObjectProposals proposed;
  proposed.points.origin_0 = 0.1 * k * scene.sensor_mps;
  proposed.sensor_velocity_0 = scene.sensor_mps;
  proposed.parameters.min_evidence = 100;
  for (const Vector3d& place_0 : places_0) {
    std::vector<std::int32_t> cluster;
    for (int n = 0; n < scene.points; ++n) {
      cluster.push_back(static_cast<std::int32_t>(scan->returns.size()));
      const Vector3d up(0, 0, 0.1 * n / (scene.points - 1) - 0.05);
      add_point(place_0 + up - proposed.points.origin_0, scene.rays_through, *scan, proposed);
    }
    proposed.faint.push_back(cluster);
  }
  if (scene.body) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d off(corner & 1 ? 0.5 : -0.5, corner & 2 ? -0.5 : -1.5, corner & 4 ? 0.5 : -0.5);
      add_point(places_0[0] + off - proposed.points.origin_0, 0, *scan, proposed);
      proposed.object.back() = 1;
    }
    proposed.objects = 1;
    proposed.evidence.resize(1);
  }
  proposed.scan = scan;
  proposed.trace.resize(scan->returns.size());
  return proposed;
}

// The number of the object that the first cluster is in the last scan; 0: none. `place`: of all clusters, by
// scan.
template <class Places>
int first_found(Places&& places, const Scene& scene = {}, const std::vector<TrackedObject>& movers = {}) {
  StraightPaths paths;
  for (int k = 0; k < kScans; ++k) {
    ObjectProposals proposed = faint_clusters(k, places(k), scene);
    const std::vector<bool> on_path = paths.find(proposed, movers);
    EXPECT_EQ(on_path.size(), static_cast<std::size_t>(proposed.objects));
    EXPECT_EQ(proposed.evidence.size(), on_path.size());
    if (k + 1 < kScans) continue;
    const int number = proposed.object[0];
    for (int n = 1; n < scene.points; ++n) EXPECT_EQ(proposed.object[static_cast<std::size_t>(n)], number);
    const int of_body = scene.body ? 1 : 0;
    EXPECT_TRUE(number <= of_body || on_path[static_cast<std::size_t>(number) - 1]);
    return number;
  }
  return 0;
}

std::vector<Vector3d> walker(int k) { return {{20, 0.3 * k, 0}}; }

TEST(StraightPaths, FollowWhatMovesSteadilyAndNothingElse) {
  EXPECT_TRUE(first_found(walker));
  EXPECT_TRUE(first_found([](int k) { return std::vector<Vector3d>{{20 - 2.0 * k, 8, 0}}; }));
  EXPECT_FALSE(first_found([](int) { return std::vector<Vector3d>{{20, 0, 0}}; }));
  // Forth and back: no velocity meets more than every other place.
  // One place in every second scan, as an edge is seen: it never leaves.
  EXPECT_FALSE(first_found([](int k) { return std::vector<Vector3d>{{20, k % 2 == 0 ? 0 : 0.1, 0}}; }));
  EXPECT_FALSE(first_found([](int k) { return std::vector<Vector3d>{{20, k % 2 == 0 ? 0 : 3.0, 0}}; }));
}

TEST(StraightPaths, FindNothingInFoliage) {
  // Twenty clusters in a bush of 4 m: every path meets some.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> within(-2, 2);
  int found = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const int number = first_found([&](int) {
      std::vector<Vector3d> bush;
      for (int n = 0; n < 20; ++n) bush.emplace_back(10 + within(random), within(random), within(random) / 2);
      return bush;
    });
    found += number != 0 ? 1 : 0;
  }
  EXPECT_LE(found, 1);  // .05 of 20 are expected
}

// A walker comes up to a post at 3 m/s: the post is on his path, and was in its place in nine of eleven
// scans.
TEST(StraightPaths, DoNotFollowWhatIsSeenInPlace) {
  EXPECT_FALSE(first_found([](int k) {
    std::vector<Vector3d> places;
    if (k != 3 && k != 4) places.emplace_back(20, 0, 0);
    if (k + 1 < kScans) places.emplace_back(20, -0.3 * (kScans - 1 - k), 0);
    return places;
  }));
}

// Clusters on both sides of a place, each scan nearer to it: neither direction stands out.
TEST(StraightPaths, FollowNoPathIfTheOppositeOneIsMetAsOften) {
  EXPECT_FALSE(first_found([](int k) {
    const double away_m = 0.5 * (kScans - 1 - k);
    return std::vector<Vector3d>{{20, away_m, 0}, {20, -away_m, 0}};
  }));
}

// One cluster comes and one goes on the same line: both orders of its places are met.
TEST(StraightPaths, FollowNoPathWhosePlacesAreMetInTheOppositeOrderToo) {
  EXPECT_FALSE(first_found([](int k) {
    return std::vector<Vector3d>{{20, -0.3 * (kScans - 1 - k), 0}, {20, -0.3 * k, 0}};
  }));
}

// Clusters 20 m away reach 0.25 m + 0.4 x 2 degrees x 20 m = 0.53 m. At half his velocity a walker of 1.2 m/s
// is met in 8 of 11 scans: it tells nothing, as he is on his own path in all of them.
TEST(StraightPaths, FollowASlowWalkerSeenThroughout) {
  EXPECT_TRUE(first_found([](int k) { return std::vector<Vector3d>{{20, 0.12 * k, 0}}; }));
}

// Seven scans meet the path, four of them half its velocity. No velocity, and the opposite order, are met in
// two at most, which this path would stand out from.
TEST(StraightPaths, FollowNoPathMetNowAndThenWhereHalfItsVelocityIsMetToo) {
  EXPECT_FALSE(first_found([](int k) {
    const std::set<int> seen = {11, 10, 7, 6, 5, 3, 2, 1};
    return seen.contains(k) ? std::vector<Vector3d>{{20, 0.16 * k, 0}} : std::vector<Vector3d>{};
  }));
}

// Two of three scans see the walker `aside_m` above or below his path.
TEST(StraightPaths, MeetWhatIsWithinTheReachOfAPath) {
  const auto swaying = [](double aside_m) {
    return [=](int k) {
      const double up_m = k % 3 == 2 ? 0 : k % 3 == 0 ? aside_m : -aside_m;
      return std::vector<Vector3d>{{20, 0.3 * k, up_m}};
    };
  };
  EXPECT_TRUE(first_found(swaying(0.5)));
  EXPECT_FALSE(first_found(swaying(0.56)));
}

TEST(StraightPaths, FollowUpToFortyMetresPerSecond) {
  const auto at = [](double speed_mps) {
    return [=](int k) { return std::vector<Vector3d>{{20, 0.1 * speed_mps * (k - kScans / 2), 0}}; };
  };
  EXPECT_TRUE(first_found(at(39)));
  EXPECT_FALSE(first_found(at(41)));
}

// Each of four scans has a velocity for the walker and for every cluster near to him, at most 200.
TEST(StraightPaths, FollowNothingInACrowd) {
  const auto among = [](int others) {
    return [=](int k) {
      std::vector<Vector3d> places = walker(k);
      for (int n = 0; n < others; ++n) places.emplace_back(20, 2 + 0.01 * n, 4);
      return places;
    };
  };
  EXPECT_TRUE(first_found(among(49)));
  EXPECT_FALSE(first_found(among(50)));
}

TEST(StraightPaths, LeaveAnObjectOfManyPointsToItsEvidence) {
  EXPECT_TRUE(first_found(walker, {.points = 50}));
  EXPECT_FALSE(first_found(walker, {.points = 51}));
}

TEST(StraightPaths, DoNotFollowWhatKeepsPaceWithTheSensorUnlessRaysPassThrough) {
  const Vector3d sensor_mps(20, 0, 0);
  const auto beside = [](int k) { return std::vector<Vector3d>{{10 + 2.0 * k, 4, 0}}; };
  EXPECT_TRUE(first_found(beside));
  EXPECT_FALSE(first_found(beside, {.sensor_mps = sensor_mps}));
  EXPECT_TRUE(first_found(beside, {.sensor_mps = sensor_mps, .rays_through = 4}));
}

TEST(StraightPaths, GiveAPartToTheBodyThatMovesAndReachesIt) {
  const Vector3d velocity_0(0, 3, 0);
  const Scene with_body{.body = true};
  TrackedObject mover;  // the body, as the scan before the last has it
  mover.time = start_of(kScans - 2);
  mover.velocity_0 = velocity_0;
  mover.extent_0 = {1, 1, 1};
  mover.centre_0 = {20, 0.3 * (kScans - 2) - 1, 0};
  EXPECT_EQ(first_found(walker, with_body, {mover}), 1);
  EXPECT_EQ(first_found(walker, with_body), 2);    // the body did not move: the cluster is another thing
  EXPECT_EQ(first_found(walker, {}, {mover}), 1);  // of its own: the body is not proposed again
  mover.centre_0.y() -= 0.9;                       // reaches the body, and not the cluster
  EXPECT_EQ(first_found(walker, with_body, {mover}), 2);
  mover.centre_0.x() -= 3;  // neither
  EXPECT_EQ(first_found(walker, with_body, {mover}), 2);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
