#pragma once

#include <string>
#include <string_view>

namespace mapless::app {

/// The bytes as text (RFC 4648), for data within a page.
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace mapless::app
