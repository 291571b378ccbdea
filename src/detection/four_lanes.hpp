#pragma once

#include <array>
#include <cstddef>
#include <cstring>

namespace mapless {

/// Four numbers that share each instruction (GCC's and Clang's vector extension: any processor with vectors
/// of 128 bits, with no flags). Comparisons give masks of 0 and -1; `mask ? a : b` chooses lane by lane.
using Floats = float __attribute__((vector_size(16)));
using Ints = int __attribute__((vector_size(16)));

inline Floats magnitude(Floats a) { return a < 0 ? -a : a; }
/// b where either is not a number.
inline Floats smaller(Floats a, Floats b) { return a < b ? a : b; }
inline Floats larger(Floats a, Floats b) { return a > b ? a : b; }
inline Floats clamped(Floats a, float least, float most) {
  return larger(smaller(a, Floats{} + most), Floats{} + least);
}
inline Ints truncated(Floats a) { return __builtin_convertvector(a, Ints); }
inline Floats to_floats(Ints a) { return __builtin_convertvector(a, Floats); }
inline bool all(Ints mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }
inline bool none(Ints mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) == 0; }

/// The first, second, third and fourth numbers of four objects that hold four numbers from byte `offset` on.
template <class Object>
std::array<Floats, 4> members(const std::array<const Object*, 4>& objects, std::size_t offset) {
  std::array<Floats, 4> row;
  for (std::size_t k = 0; k < 4; ++k) {
    std::memcpy(&row[k], reinterpret_cast<const std::byte*>(objects[k]) + offset, sizeof(Floats));
  }
  const Floats low_a = __builtin_shufflevector(row[0], row[1], 0, 4, 1, 5);
  const Floats high_a = __builtin_shufflevector(row[0], row[1], 2, 6, 3, 7);
  const Floats low_b = __builtin_shufflevector(row[2], row[3], 0, 4, 1, 5);
  const Floats high_b = __builtin_shufflevector(row[2], row[3], 2, 6, 3, 7);
  return {__builtin_shufflevector(low_a, low_b, 0, 1, 4, 5),
          __builtin_shufflevector(low_a, low_b, 2, 3, 6, 7),
          __builtin_shufflevector(high_a, high_b, 0, 1, 4, 5),
          __builtin_shufflevector(high_a, high_b, 2, 3, 6, 7)};
}

}  // namespace mapless
