#pragma once

#include <CLI/App.hpp>

#include "verbs/verbs.hpp"

namespace mapless::app {

/// The command `mapless` with its arguments, the first of which is the name of the program. Prints results to
/// standard output, progress and errors to standard error, and returns the exit code. Does not throw.
/// `live`: adds the verb live, which a program that links DDS has.
int run_command(int argc, char** argv, AddVerb live = refuse_live);

}  // namespace mapless::app
