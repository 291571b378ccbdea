#pragma once

#include <string>

#include "reports/json.hpp"

namespace mapless::app {

/// JSON as text, one value a line. Bytes that are not UTF-8 (in file names) become U+FFFD.
[[nodiscard]] inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mapless::app
