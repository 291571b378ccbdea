#pragma once

#include <string>

#include "reports/json.hpp"
#include "run/busy_time.hpp"

namespace mapless::app {

/// Times that detection waited for reading and writing, which run on threads of their own.
struct InputOutputReport {
  double run_s = 0;                 ///< from the first scan to the last file written
  double waited_for_reading_s = 0;  ///< of that: the next scan was not read yet
  double waited_for_writing_s = 0;  ///< of that: the queue of results was full, or only writing was left
  BusyTime reading, writing;        ///< of their threads
};

[[nodiscard]] Json to_json(const InputOutputReport& report);

/// One line on waits of more than a tenth of the run and more than a second, and whether the disk or the
/// decoding caused them; empty where there were none.
[[nodiscard]] std::string trouble(const InputOutputReport& report);

}  // namespace mapless::app
