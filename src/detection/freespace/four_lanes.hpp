#pragma once

// The elements of a and b, side by side, at the indices that follow. GCC 11 has only an older form, which
// gives as many elements as a has.
#if defined(__clang__) || __GNUC__ >= 12
#define MAPLESS_HAS_SHUFFLEVECTOR
#define MAPLESS_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define MAPLESS_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, decltype((a) == (a)){__VA_ARGS__})
#endif

namespace mapless::inline v1 {

/// Four numbers that share each instruction (GCC's and Clang's vector extension: any processor with vectors
/// of 128 bits, with no flags). Comparisons give masks of 0 and -1; `mask ? a : b` chooses lane by lane.
using Floats = float __attribute__((vector_size(16)));
using Ints = int __attribute__((vector_size(16)));

}  // namespace mapless
