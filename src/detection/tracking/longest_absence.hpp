#pragma once

namespace mapless::inline v1 {

/// A track is dropped if it was not seen for longer. By then a braking object (3 m/s^2) is 1.5 m from its
/// predicted position, and another object may be there.
inline v1 {
  /// An object not seen for longer is another one when it comes back: by then it may be metres from where its
  /// last velocity puts it (braking at 3 m/s^2: 1.5 m), and something else where it was.
  inline constexpr double kLongestAbsence_s = 1;

}  // namespace mapless
