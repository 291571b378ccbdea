#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace mapless::app {

/// A long task. Calls its argument after every step; returns false where it was interrupted.
using LongTask = std::function<bool(const std::function<void()>& step_done)>;

/// Runs the tasks concurrently, started in order, each with an equal share of the threads, and shows the
/// progress of all their steps. False where any was interrupted. Throws the exception of the first task that
/// failed; the others stop at their next step.
bool work_side_by_side(const std::vector<LongTask>& tasks, std::size_t threads, std::size_t steps,
                       const std::string& unit);

}  // namespace mapless::app
