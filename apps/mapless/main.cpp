#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <unistd.h>

#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace {

namespace fs = std::filesystem;

constexpr int kFailure = 1;
constexpr int kUsage = 2;

int report(std::string message, int exit_code) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  mapless::app::say("mapless: error: {}\n", message);
  return exit_code;
}

// A descriptor that is closed would be given to the next file that is opened, and what is printed end up in a
// result. This one is held, and writing to it fails.
void hold_standard_descriptors() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (fcntl(fd, F_GETFD) == -1 && open("/dev/null", O_RDONLY) != fd) std::_Exit(kFailure);
  }
}

[[noreturn]] void refuse_output(const std::string& reason) {
  throw mapless::OutputError(
      {"standard output", "", "", "cannot be written: " + reason, "check the disk or the pipe it goes to"});
}

// What was printed may still be in the buffer, and a full disk only show now.
void require_printed() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) refuse_output(std::strerror(errno));
}

int run_verb(CLI::App& command, const int& exit_code, int argc, char** argv) {
  try {
    command.parse(argc, argv);
  } catch (const fs::filesystem_error& error) {
    throw mapless::InputError({error.path1().string(), "", "",
                               "cannot be accessed: " + error.code().message(),
                               "check the path and its permissions"});
  } catch (const std::system_error& error) {
    // As fmt::print says it, which prints to standard output alone.
    if (std::string_view(error.what()).starts_with("cannot write to file"))
      refuse_output(error.code().message());
    throw;
  } catch (const std::bad_alloc&) {
    throw mapless::InputError({"", "", "", "not enough memory", "use fewer threads"});
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return command.exit(error);  // --help, --version
    return report(std::string(error.what()) + "; see mapless --help", kUsage);
  }
  if (command.get_subcommands().empty()) return report("no verb given; see mapless --help", kUsage);
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_descriptors();
  CLI::App command{
      "Labels every point of a spinning 3D lidar as dynamic (moving now) or static, online and without a map "
      "(arXiv 1809.06972).",
      "mapless"};
  command.set_version_flag("--version", "mapless " MAPLESS_VERSION);
  command.require_subcommand(0, 1);
  command.footer(
      "Exit codes: 0 success, 1 failure, 2 wrong usage, 128 + N ended by signal N (130: interrupted). "
      "'mapless VERB --help' lists the options of a verb.");
  int exit_code = 0;
  mapless::app::add_detect(command, exit_code);
  mapless::app::add_odometry(command, exit_code);
  mapless::app::add_evaluate(command, exit_code);
  mapless::app::add_info(command, exit_code);
  mapless::app::add_render(command, exit_code);
  mapless::app::add_simulate(command, exit_code);
  mapless::app::add_benchmark(command, exit_code);
  mapless::app::add_config(command, exit_code);
  try {
    const int code = run_verb(command, exit_code, argc, argv);
    require_printed();
    return code;
  } catch (const mapless::ParameterError& error) {
    return report(error.what(), kUsage);
  } catch (const std::exception& error) {
    return report(error.what(), kFailure);
  }
}
