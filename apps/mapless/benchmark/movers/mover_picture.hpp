#pragma once

#include <functional>

#include "benchmark/movers/mover_views.hpp"
#include "pictures/canvas.hpp"

namespace mapless::app {

/// Colours of true and false positives and negatives, those of `mapless render` on light ground (Okabe and
/// Ito 2008).
inline constexpr Color kRightColor{0, 158, 115}, kFalseColor{213, 94, 0}, kMissedColor{0, 114, 178},
    kStillColor{176, 183, 193}, kPaper{250, 250, 248};

/// The surroundings of a moving object, viewed from behind and above the sensor. `dynamic`: which points are
/// labelled dynamic; true positives green, false positives orange, false negatives blue, the rest grey.
/// `margin_m` is shown around the mover.
[[nodiscard]] Canvas draw_mover(const MoverView& view, int width, int height, float margin_m,
                                const std::function<bool(const ViewedPoint&)>& dynamic);

}  // namespace mapless::app
