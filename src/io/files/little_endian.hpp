#pragma once

#include <bit>
#include <string>

namespace mapless::inline v1 {

static_assert(std::endian::native == std::endian::little);

/// Appends the bytes of a number, the lowest first.
template <class Number>
void append(std::string& out, Number value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace mapless
