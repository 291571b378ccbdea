#pragma once

#include <exception>
#include <string>

namespace mapless::app {

/// What the process exits with. A script may rely on these numbers.
enum ExitCode : int {
  kSuccess = 0,
  kFailure = 1,   ///< the environment (permissions, memory, an error of the disk) or the program itself
  kUsage = 2,     ///< an option or a parameter is wrong
  kBadInput = 3,  ///< the input is missing, damaged or wrong
  kNotTrusted =
      4,  ///< finished, and the result or a part of it is not trustworthy; a line on stderr says which
  kTemporary = 75,    ///< the folder is in use, or the disk is full; the number is EX_TEMPFAIL of sysexits.h
  kSignalBase = 128,  ///< plus the number of the signal that ended the run
};

/// The code for an exception that ends a verb.
[[nodiscard]] ExitCode exit_code_of(const std::exception& error);

/// The table of all codes, one a line, for --help.
[[nodiscard]] std::string exit_code_table();

}  // namespace mapless::app
