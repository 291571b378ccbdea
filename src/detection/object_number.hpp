#pragma once

#include <cstdint>
#include <limits>

namespace mapless::inline v1 {

/// Largest number of an object in one scan: a label has 16 bits for it. Objects beyond share the last number.
inline constexpr int kMaxObjectNumber = std::numeric_limits<std::uint16_t>::max();

}  // namespace mapless
