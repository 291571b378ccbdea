#pragma once

namespace mapless::inline v1 {

/// A track is dropped if it was not seen for longer. By then a braking object (3 m/s^2) is 1.5 m from its
/// predicted position, and another object may be there.
inline constexpr double kLongestAbsence_s = 1;

}  // namespace mapless
