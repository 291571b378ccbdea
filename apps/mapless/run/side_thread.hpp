#pragma once

#include <exception>
#include <functional>
#include <thread>
#include <utility>

#include "run/bounded_queue.hpp"

namespace mapless::app {

/// A thread that does one thing at a time beside the one that gives it.
class SideThread {
 public:
  SideThread() : thread_([this] { run(); }) {}
  /// Waits for what is being done.
  ~SideThread() {
    begun_.close();
    thread_.join();
  }
  SideThread(const SideThread&) = delete;
  SideThread& operator=(const SideThread&) = delete;

  /// Begins; what was begun before must have been waited for.
  void start(std::function<void()> work) { begun_.push(std::move(work)); }
  /// Waits until it is done. Throws what it threw.
  void wait() {
    if (const auto failure = *done_.pop()) std::rethrow_exception(failure);
  }

 private:
  void run() {
    while (const auto work = begun_.pop()) {
      std::exception_ptr failure;
      try {
        (*work)();
      } catch (...) {
        failure = std::current_exception();
      }
      done_.push(failure);
    }
  }

  BoundedQueue<std::function<void()>> begun_{1};
  BoundedQueue<std::exception_ptr> done_{1};
  std::thread thread_;
};

}  // namespace mapless::app
