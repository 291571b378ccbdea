#include <cstdint>

#include "io/formats/pcd/pcd.hpp"

namespace mapless::inline v1 {

// A control byte below 32 starts a run of literal bytes; any other one a copy of bytes written `distance`
// bytes before.
bool lzf_decompress(std::string_view in, std::size_t size, std::string& out) {
  out.clear();
  constexpr std::size_t kMostPerByte = 88;  // three bytes make at most 264
  if (size > kMostPerByte * in.size()) return false;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::size_t { return static_cast<std::uint8_t>(in[at++]); };
  while (at < in.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t run = control + 1;
      if (run > in.size() - at || run > size - out.size()) return false;
      out.append(in.substr(at, run));
      at += run;
      continue;
    }
    std::size_t length = control >> 5;
    if (at + (length == 7 ? 2 : 1) > in.size()) return false;
    if (length == 7) length += next();
    length += 2;
    const std::size_t distance = ((control & 31) << 8) + next() + 1;
    if (distance > out.size() || length > size - out.size()) return false;
    // Byte by byte: source and target may overlap.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
  }
  return out.size() == size;
}

}  // namespace mapless
