#include "benchmark/work_pool.hpp"

#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

namespace mapless::app {
namespace MAPLESS_FILE {

using StepDone = std::function<void()>;

TEST(WorkPool, DoesEveryTaskOnceOnItsPartOfTheThreads) {
  for (const std::size_t threads : {1u, 2u, 8u}) {
    std::vector<std::atomic<int>> done(4);
    std::atomic<int> most_threads = 0;
    std::vector<LongTask> tasks;
    for (auto& mine : done) {
      tasks.emplace_back([&mine, &most_threads](const StepDone& step_done) {
        most_threads = std::max(most_threads.load(), tbb::this_task_arena::max_concurrency());
        ++mine;
        step_done();
        return true;
      });
    }
    EXPECT_TRUE(work_side_by_side(tasks, threads, 4, "steps"));
    for (const auto& times : done) EXPECT_EQ(times, 1);
    EXPECT_EQ(most_threads, threads == 8 ? 2 : 1);
  }
  EXPECT_TRUE(work_side_by_side({}, 4, 0, "steps"));
}

TEST(WorkPool, AfterAnInterruptNoTaskIsBegun) {
  int begun = 0;
  const LongTask interrupted = [&begun](const StepDone&) {
    ++begun;
    return false;
  };
  EXPECT_FALSE(work_side_by_side({interrupted, interrupted, interrupted}, 1, 3, "steps"));
  EXPECT_EQ(begun, 1);
}

TEST(WorkPool, AFailureEndsTheOthersAtTheirNextStep) {
  std::atomic<bool> other_runs = false;
  const LongTask failing = [&other_runs](const StepDone&) -> bool {
    while (!other_runs) {
    }
    throw std::runtime_error("disk full");
  };
  const LongTask endless = [&other_runs](const StepDone& step_done) -> bool {
    other_runs = true;
    for (;;) step_done();
  };
  try {
    work_side_by_side({failing, endless}, 2, 1000, "steps");
    ADD_FAILURE() << "did not throw";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "disk full");
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
