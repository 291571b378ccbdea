#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

#include <tbb/parallel_for.h>

namespace mapless::inline v1 {

/// Of at most so many elements; the parts do not depend on the number of threads.
inline constexpr std::size_t kPartSize = 8192;

[[nodiscard]] inline std::size_t count_parts(std::size_t size) { return (size + kPartSize - 1) / kPartSize; }

/// Calls body(part, begin, end) for each part of 0 to `size`, on several threads. Where parts throw, the
/// exception is that of the first of them, as of a loop in order.
template <class Body>
void for_parts(std::size_t size, Body&& body) {
  std::vector<std::exception_ptr> errors(count_parts(size));
  tbb::parallel_for(std::size_t{0}, errors.size(), [&](std::size_t part) {
    try {
      body(part, part * kPartSize, std::min(size, (part + 1) * kPartSize));
    } catch (...) {
      errors[part] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace mapless
