#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace mapless::app {

/// JSON as text, one value a line. Bytes of file names that are no UTF-8 come out as U+FFFD.
[[nodiscard]] inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace mapless::app
