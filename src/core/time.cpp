#include "core/argument_checks.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1::detail {

void refuse_seconds(double seconds) {
  refuse_argument("from_seconds", "s", seconds, -Duration::kMaxSeconds, Duration::kMaxSeconds);
}

}  // namespace mapless::inline v1::detail
