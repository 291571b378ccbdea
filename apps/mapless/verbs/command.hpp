#pragma once

namespace mapless::app {

/// The command `mapless` with its arguments, the first of which is the name of the program. Prints results to
/// standard output, progress and errors to standard error, and returns the exit code. Does not throw.
int run_command(int argc, char** argv);

}  // namespace mapless::app
