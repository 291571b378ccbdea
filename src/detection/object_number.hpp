#pragma once

#include <cstdint>
#include <limits>

namespace mapless::inline v1 {

/// A label has 16 bits for its object; objects beyond share the last number rather than turn static.
inline constexpr int kMaxObjectNumber = std::numeric_limits<std::uint16_t>::max();

}  // namespace mapless
