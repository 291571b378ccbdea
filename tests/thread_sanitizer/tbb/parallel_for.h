#pragma once

// Stands in for oneTBB's header of this name in ThreadSanitizer builds only. Debian's libtbb is not
// instrumented: the sanitizer cannot see it hand work from thread to thread, and reports races that are none.
// Plain threads it understands, so what it then reports of our loop bodies is true. Chunks are claimed with
// relaxed order, which adds no ordering between threads that could hide a race.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>

namespace tbb {

template <class Index, class Body>
void parallel_for(const blocked_range<Index>& range, const Body& body) {
  const std::size_t size = range.size();
  const std::size_t chunk = std::max<std::size_t>(1, range.grainsize());
  const std::size_t allowed = global_control::active_value(global_control::max_allowed_parallelism);
  const std::size_t threads = std::min(std::max<std::size_t>(1, allowed), size / chunk + 1);
  std::atomic<std::size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t first; (first = next.fetch_add(chunk, std::memory_order_relaxed)) < size;) {
        const Index begin = range.begin() + static_cast<Index>(first);
        body(blocked_range<Index>(begin, begin + static_cast<Index>(std::min(chunk, size - first))));
      }
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> workers;
    for (std::size_t i = 1; i < threads; ++i) workers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

template <class Index, class Body>
void parallel_for(Index first, Index last, const Body& body) {
  parallel_for(blocked_range<Index>(first, std::max(first, last)), [&](const blocked_range<Index>& range) {
    for (Index i = range.begin(); i != range.end(); ++i) body(i);
  });
}

}  // namespace tbb
