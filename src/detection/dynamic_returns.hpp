#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace mapless::inline v1 {

/// Calls `visit(i)` for every return i that belongs to an object, by increasing index; it may change
/// object[i]. Hardly any do, so four are tested at a time.
template <class Visit>
void for_each_dynamic(const std::vector<std::uint16_t>& object, Visit&& visit) {
  std::size_t i = 0;
  for (; i + 4 <= object.size(); i += 4) {
    std::uint64_t four = 0;
    std::memcpy(&four, object.data() + i, sizeof(four));
    if (four == 0) continue;
    for (std::size_t k = i; k < i + 4; ++k) {
      if (object[k] != 0) visit(k);
    }
  }
  for (; i < object.size(); ++i) {
    if (object[i] != 0) visit(i);
  }
}

}  // namespace mapless
