#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mapless::inline v1 {

/// As diagnostic_msgs/DiagnosticStatus.
enum class LiveLevel : std::uint8_t { ok = 0, warning = 1, error = 2 };

/// Something that happened, for the log.
struct LiveEvent {
  LiveLevel level;
  std::string text;
};

/// The state of a LiveDetector, as diagnostic_msgs/DiagnosticStatus holds it.
struct LiveDiagnostics {
  LiveLevel level = LiveLevel::ok;
  std::string message;
  bool has_clouds = false;                                  ///< one has come
  std::string sensor;                                       ///< name of the model; empty: not known yet
  std::vector<std::pair<std::string, std::string>> values;  ///< clouds, rates, latencies, motion
};

}  // namespace mapless
