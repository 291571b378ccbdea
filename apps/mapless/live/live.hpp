#pragma once

#include <CLI/App.hpp>

namespace mapless::app {

/// Adds the verb live, as those of verbs.hpp.
void add_live(CLI::App& app, int& exit_code);

}  // namespace mapless::app
