#pragma once

#include <string_view>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Throws InputError that names the source and the field unless the time is within Time::kLargestOutside_ns.
/// Every time that enters from outside passes it: arithmetic on such times does not overflow.
void require_time(std::string_view source, std::string_view field, Time time);

}  // namespace mapless
