#include "core/number_text.hpp"

#include <cstdint>

#include <fmt/format.h>

namespace mapless::inline v1 {

std::string decimal_seconds(Time time) {
  constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;
  const std::int64_t ns = time.nanoseconds();
  // The magnitude of the most negative time does not fit the signed type.
  const std::uint64_t magnitude = ns < 0 ? -static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", magnitude / kNanosecondsPerSecond,
                     magnitude % kNanosecondsPerSecond);
}

}  // namespace mapless
