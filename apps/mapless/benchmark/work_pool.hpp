#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace mapless::app {

/// A long piece of work. Calls its argument after every step, and returns false where it was interrupted.
using LongTask = std::function<bool(const std::function<void()>& step_done)>;

/// Does the tasks side by side, in order, each with an equal part of the threads, and shows the progress of
/// all their steps. False where any was interrupted. Throws what the first of the tasks that failed threw;
/// the others are given up at their next step.
bool work_side_by_side(const std::vector<LongTask>& tasks, std::size_t threads, std::size_t steps,
                       const std::string& unit);

}  // namespace mapless::app
