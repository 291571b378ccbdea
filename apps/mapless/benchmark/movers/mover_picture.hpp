#pragma once

#include <functional>

#include "benchmark/movers/mover_views.hpp"
#include "pictures/canvas.hpp"

namespace mapless::app {

/// Colours of what was said of a point, as `mapless render` has them.
inline constexpr Color kRightColor{22, 163, 84}, kFalseColor{226, 58, 46}, kMissedColor{45, 120, 235},
    kStillColor{176, 183, 193}, kPaper{250, 250, 248};

/// The surroundings of a mover seen from behind and above the sensor. `dynamic` says which points count as
/// dynamic: rightly green, falsely red, missed blue, the rest grey. `margin_m` is shown around the mover.
[[nodiscard]] Canvas draw_mover(const MoverView& view, int width, int height, float margin_m,
                                const std::function<bool(const ViewedPoint&)>& dynamic);

}  // namespace mapless::app
