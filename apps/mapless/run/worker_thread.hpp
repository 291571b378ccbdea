#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <thread>
#include <utility>

#include "run/bounded_queue.hpp"
#include "run/busy_time.hpp"

namespace mapless::app {

/// Calls `work` for one item after another, in the order added, on a thread of its own. After the first
/// exception no more items are processed; add() and finish() throw it.
template <class T>
class WorkerThread {
 public:
  /// At most `capacity` items wait to be processed.
  WorkerThread(std::size_t capacity, std::function<void(T&)> work)
      : queue_(capacity), work_(std::move(work)), thread_([this] { run(); }) {}
  /// Drops the items that wait.
  ~WorkerThread() {
    queue_.abandon();
    join();
  }
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  /// Waits while the queue is full.
  void add(T thing) {
    if (!queue_.push(std::move(thing))) finish();
  }
  /// Waits for the last item to be processed, or the first to fail. No items can be added from then on.
  void join() {
    queue_.close();
    if (thread_.joinable()) thread_.join();
  }
  /// The same; throws the exception of the first failure.
  void finish() {
    join();
    if (failure_) std::rethrow_exception(failure_);
  }
  /// How long the work took; once joined.
  [[nodiscard]] const BusyTime& busy() const { return busy_; }

 private:
  void run() {
    while (auto thing = queue_.pop()) {
      const BusyTime::Measure measure(busy_);
      try {
        work_(*thing);
      } catch (...) {
        failure_ = std::current_exception();
        queue_.abandon();
        return;
      }
    }
  }

  BoundedQueue<T> queue_;
  std::function<void(T&)> work_;
  BusyTime busy_;               // of the thread, until it is joined
  std::exception_ptr failure_;  // the same
  std::thread thread_;
};

}  // namespace mapless::app
