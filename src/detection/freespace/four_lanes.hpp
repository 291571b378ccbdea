#pragma once

namespace mapless::inline v1 {

/// Four numbers that share each instruction (GCC's and Clang's vector extension: any processor with vectors
/// of 128 bits, with no flags). Comparisons give masks of 0 and -1; `mask ? a : b` chooses lane by lane.
using Floats = float __attribute__((vector_size(16)));
using Ints = int __attribute__((vector_size(16)));

}  // namespace mapless
