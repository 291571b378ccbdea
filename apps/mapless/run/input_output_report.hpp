#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "run/busy_time.hpp"

namespace mapless::app {

/// How reading and writing, which go on beside detection, held it back.
struct InputOutputReport {
  double run_s = 0;                 ///< from the first scan asked for to the last file written
  double waited_for_reading_s = 0;  ///< of that: nothing to detect in, since it was not read yet
  double waited_for_writing_s = 0;  ///< of that: no room for what was found, or only writing left to do
  BusyTime reading, writing;        ///< of their threads
};

[[nodiscard]] nlohmann::ordered_json to_json(const InputOutputReport& report);

/// A line for people on what took more than a tenth of the run, and more than a second, from detection; empty
/// where nothing did. Says whether the disk is slow or the decoding.
[[nodiscard]] std::string trouble(const InputOutputReport& report);

}  // namespace mapless::app
