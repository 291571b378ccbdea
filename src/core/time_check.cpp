#include "core/time_check.hpp"

#include <string>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {

void require_time(std::string_view source, std::string_view field, Time time) {
  const std::int64_t ns = time.nanoseconds();
  if (ns >= -Time::kLargestOutside_ns && ns <= Time::kLargestOutside_ns) return;
  throw InputError({std::string(source), std::string(field), fmt::format("{} ns", ns),
                    "not within 126 years of 0", "correct the times, or name their unit"});
}

}  // namespace mapless
