#include "odometry/keypoints/edges.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/small_scan.hpp"

namespace mapless {
namespace MAPLESS_FILE {

// A wall at 5 m, and one return at `range_m` before it, in column 10 of the middle laser of three.
LidarScan with_pole(float range_m) {
  LidarScan scan = test::small_scan({0, 0, 0});
  LidarReturn& pole = scan.returns[static_cast<std::size_t>(scan.cell(1, 10))];
  pole.position_v *= range_m / pole.range_m;
  pole.range_m = range_m;
  return scan;
}

TEST(Edges, ThePoleIsOneAndTheWallBehindItIsNot) {
  const LidarScan scan = with_pole(3);
  const auto edges = select_edges(scan, {});
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0].return_index, static_cast<std::uint32_t>(scan.cell(1, 10)));
  EXPECT_EQ(edges[0].laser, 1);
}

TEST(Edges, AStepOfLessThanHalfAMetreIsNone) { EXPECT_TRUE(select_edges(with_pole(4.6F), {}).empty()); }

TEST(Edges, ReturnsOfTheVehicleItselfAreNone) { EXPECT_TRUE(select_edges(with_pole(0.9F), {}).empty()); }

// Along a wall 1 m aside, columns 2 degrees apart see it at 1 / sin(angle): 0.5 m and more from one to the
// next.
TEST(Edges, AWallSeenAslantHasNone) {
  LidarScan scan = test::small_scan({0, 0, 0});
  for (LidarReturn& r : scan.returns) {
    const float range_m = 1 / std::sin(0.035F * static_cast<float>(r.column % 40 + 1));
    r.position_v *= range_m / r.range_m;
    r.range_m = range_m;
  }
  for (const ScanPoint& edge : select_edges(scan, {})) {
    const int place = scan.returns[edge.return_index].column % 40;
    EXPECT_TRUE(place == 0 || place == 39) << place;  // where the next wall begins
  }
}

// A ray beside the return that reached nothing makes it an edge; one that failed says nothing.
TEST(Edges, BesideARayThatReachedNothing) {
  for (const auto& [code, edges] : {std::pair(ReturnCode::nothing, 2u), std::pair(ReturnCode::faulty, 0u),
                                    std::pair(ReturnCode::absent, 0u)}) {
    LidarScan scan = test::small_scan({0, 0, 0});
    scan.cells[static_cast<std::size_t>(scan.columns + 10)] = empty_cell(code);
    // The return of that cell is not in the image any more; its neighbours are.
    std::size_t found = 0;
    for (const ScanPoint& edge : select_edges(scan, {})) {
      const std::int32_t column = scan.returns[edge.return_index].column;
      found += column == 9 || column == 11 ? 1 : 0;
    }
    EXPECT_EQ(found, edges) << static_cast<int>(code);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
