#include "terminal/exit_codes.hpp"

#include <mapless/core/errors.hpp>

namespace mapless::app {

ExitCode exit_code_of(const std::exception& error) {
  if (dynamic_cast<const ParameterError*>(&error) != nullptr) return kUsage;
  if (dynamic_cast<const TemporaryError*>(&error) != nullptr) return kTemporary;
  if (dynamic_cast<const AccessError*>(&error) != nullptr) return kFailure;
  if (dynamic_cast<const InputError*>(&error) != nullptr) return kBadInput;
  if (dynamic_cast<const TrajectoryDomainError*>(&error) != nullptr) return kBadInput;
  return kFailure;
}

std::string exit_code_table() {
  return "Exit codes:\n"
         "  0        success: the result is complete\n"
         "  1        failure of the environment (permissions, memory, the disk) or of the program\n"
         "  2        wrong usage: an option or a parameter\n"
         "  3        the input is missing, damaged or wrong: trying again cannot help\n"
         "  4        finished, but the result is not trustworthy; stderr says why and for which scans\n"
         "  75       trying again can help: the folder is in use, or the disk is full\n"
         "  128 + N  ended by signal N (130: interrupted); finished scans are kept\n"
         "'mapless VERB --help' lists the options of a verb.";
}

}  // namespace mapless::app
