#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace mapless::app {

/// Prints to stderr. If stderr cannot be written (closed, disk full) the text is lost and the run continues;
/// fmt::print would throw.
template <class... Arguments>
void say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  const std::string text = fmt::format(format, std::forward<Arguments>(arguments)...);
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace mapless::app
