#pragma once

#include <cstdint>

namespace mapless::inline v1 {

/// Returns of one laser that lie one after another on a straight line: a cut through one face of something.
struct RowLine {
  std::int32_t first, last;
};

}  // namespace mapless
