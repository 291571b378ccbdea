#pragma once

#include <string>

#include "reports/json.hpp"

namespace mapless::app {

/// JSON as text, one value a line. Bytes that are not UTF-8 (in file names) become U+FFFD.
[[nodiscard]] inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// JSON that can stand in a script element: that ends at the first "</", and "<!--" begins a comment.
[[nodiscard]] inline std::string json_for_script(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) c == '<' ? out += "\\u003c" : out += c;
  return out;
}

}  // namespace mapless::app
