#include "benchmark/work_pool.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include <tbb/task_arena.h>

#include "terminal/progress.hpp"

namespace mapless::app {
namespace {

struct GivenUp {};  // thrown through a task whose result nobody wants any more

class WorkPool {
 public:
  WorkPool(const std::vector<LongTask>& tasks, std::size_t threads_each, std::size_t steps,
           const std::string& unit)
      : tasks_(tasks), threads_each_(static_cast<int>(threads_each)), steps_(steps), progress_(unit) {}

  void work() {
    tbb::task_arena arena(threads_each_);
    for (std::size_t i = next_++; i < tasks_.size() && !stopped_; i = next_++) {
      try {
        if (!arena.execute([&] { return tasks_[i]([this] { step_done(); }); })) stopped_ = true;
      } catch (const GivenUp&) {
        return;
      } catch (...) {
        fail(i, std::current_exception());
      }
    }
  }

  bool finish() {
    progress_.clear();
    if (failure_) std::rethrow_exception(failure_->what);
    return !stopped_;
  }

 private:
  struct Failure {
    std::size_t task;
    std::exception_ptr what;
  };

  void step_done() {
    if (failed_) throw GivenUp();
    const std::lock_guard lock(mutex_);
    progress_.update(++done_, steps_);
  }
  void fail(std::size_t task, std::exception_ptr what) {
    const std::lock_guard lock(mutex_);
    if (!failure_ || task < failure_->task) failure_ = Failure{task, std::move(what)};
    failed_ = true;
    stopped_ = true;
  }

  const std::vector<LongTask>& tasks_;
  int threads_each_;
  std::size_t steps_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stopped_{false}, failed_{false};
  std::mutex mutex_;  // of the rest
  Progress progress_;
  std::size_t done_ = 0;
  std::optional<Failure> failure_;
};

}  // namespace

bool work_side_by_side(const std::vector<LongTask>& tasks, std::size_t threads, std::size_t steps,
                       const std::string& unit) {
  if (tasks.empty()) return true;
  const std::size_t workers = std::min(threads, tasks.size());
  WorkPool pool(tasks, threads / workers, steps, unit);
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < workers; ++i) others.emplace_back([&pool] { pool.work(); });
    pool.work();
  }
  return pool.finish();
}

}  // namespace mapless::app
