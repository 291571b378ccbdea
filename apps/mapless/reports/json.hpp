#pragma once

#include <nlohmann/json.hpp>

namespace mapless::app {

/// Keys are written in the order in which they were set.
using Json = nlohmann::ordered_json;

}  // namespace mapless::app
