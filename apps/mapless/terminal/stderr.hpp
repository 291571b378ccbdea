#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace mapless::app {

/// Prints to stderr. Where that cannot be written (closed, a full disk) nothing is said, and the work goes
/// on: fmt::print would throw.
template <class... Arguments>
void say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  const std::string text = fmt::format(format, std::forward<Arguments>(arguments)...);
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace mapless::app
