#include "detection/scan_trajectory.hpp"

#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// A sensor that drives and turns at constant rates moves so between columns and beyond the scan's ends too.
TEST(ScanTrajectory, IsTheTrajectoryThatTheScanWasCompensatedWith) {
  const auto room = test::toy_room("VLP-16", test::drive(5, 1));
  const auto scan = test::cast_scan(room, 3).scan;
  const ScanTrajectory during(*scan, compensate(scan, *room.trajectory).column_states);
  for (const double share : {-0.01, 0.0, 0.1234, 0.5, 0.9999, 1.0, 1.01}) {
    SCOPED_TRACE(share);
    const Time t = scan->start + (scan->end() - scan->start) * share;
    const TrajectoryState truth = room.trajectory->at(t), found = during.at(t);
    EXPECT_LT((found.T_v0 * truth.T_v0.inverse()).log().norm(), 1e-6);
    EXPECT_LT((found.varpi - truth.varpi).norm(), 1e-6);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
