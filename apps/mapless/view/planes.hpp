#pragma once

#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace mapless::app {

/// Appends numbers as differences modulo 2^bits to the number before, zigzag coded: small of either sign
/// become small. All low bytes come first.
template <class Unsigned>
void append_planes(std::string& out, const std::vector<Unsigned>& values) {
  using Signed = std::make_signed_t<Unsigned>;
  std::vector<Unsigned> coded(values.size());
  Unsigned before = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto difference = static_cast<Signed>(static_cast<Unsigned>(values[i] - before));
    const Unsigned sign = difference < 0 ? std::numeric_limits<Unsigned>::max() : Unsigned{0};
    coded[i] = static_cast<Unsigned>(static_cast<Unsigned>(static_cast<Unsigned>(difference) << 1U) ^ sign);
    before = values[i];
  }
  for (unsigned shift = 0; shift < 8 * sizeof(Unsigned); shift += 8) {
    for (const Unsigned c : coded) out.push_back(static_cast<char>((c >> shift) & 0xFFU));
  }
}

}  // namespace mapless::app
