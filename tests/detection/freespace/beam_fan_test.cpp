#include "detection/freespace/beam_fan.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// The search for the beams about a point steps on while a beam is below it, and stops at the last: a pose of
// the trajectory that is far off put points above that, and the search went on into what lies behind the
// beams.
TEST(BeamFan, NothingThatHasARangeIsBeyondTheOutermostBeams) {
  const float farthest_m = std::sqrt(std::numeric_limits<float>::max());  // its square is finite
  for (const std::string& name : named_models()) {
    SCOPED_TRACE(name);
    const BeamFan fan(named_model(name));
    for (const BeamFan::Bank& bank : fan.banks) {
      EXPECT_LT(bank.beams.front().up_m, -farthest_m);
      EXPECT_GT(bank.beams.back().up_m, farthest_m);
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
