#include "verbs/command.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>

#include "options/option_checks.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// A message of CLI11 has the words of the command line in it.
std::string shortened(std::string message) {
  constexpr std::size_t kLongest = 600;
  if (message.size() > kLongest) message = message.substr(0, kLongest) + "...";
  return message;
}

int report(std::string message, int exit_code) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  say("mapless: error: {}\n", message);
  return exit_code;
}

[[noreturn]] void refuse_output(const std::error_code& reason) {
  throw_write_error({"standard output", "", "", "cannot be written: " + reason.message(),
                     "check the disk or the pipe it goes to"},
                    reason);
}

// What was printed may still be in the buffer, and a full disk only show now.
void require_printed() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) refuse_output({errno, std::generic_category()});
}

int run_verb(CLI::App& command, const int& exit_code, int argc, char** argv) {
  try {
    command.parse(argc, argv);
  } catch (const fs::filesystem_error& error) {
    throw AccessError({error.path1().string(), "", "", "cannot be accessed: " + error.code().message(),
                       "check the path and its permissions"});
  } catch (const std::system_error& error) {
    // As fmt::print says it, which prints to standard output alone.
    if (std::string_view(error.what()).starts_with("cannot write to file")) refuse_output(error.code());
    throw;
  } catch (const std::bad_alloc&) {
    throw Error({"", "", "", "not enough memory", "use fewer threads"});
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return command.exit(error);  // --help, --version
    return report(shortened(error.what()) + "; see mapless --help", kUsage);
  }
  if (command.get_subcommands().empty()) return report("no verb given; see mapless --help", kUsage);
  return exit_code;
}

}  // namespace

int run_command(int argc, char** argv, AddVerb live) {
  CLI::App command{
      "Labels every point of a spinning 3D lidar as dynamic (moving now) or static, online and without a map "
      "(arXiv 1809.06972).",
      "mapless"};
  command.set_version_flag("--version", "mapless " MAPLESS_VERSION);
  command.require_subcommand(0, 1);
  command.footer(exit_code_table());
  int exit_code = 0;
  add_detect(command, exit_code);
  live(command, exit_code);
  add_odometry(command, exit_code);
  add_evaluate(command, exit_code);
  add_info(command, exit_code);
  add_render(command, exit_code);
  add_view(command, exit_code);
  add_explain(command, exit_code);
  add_export(command, exit_code);
  add_simulate(command, exit_code);
  add_benchmark(command, exit_code);
  add_config(command, exit_code);
  add_batch(command);
  for (CLI::App* verb : command.get_subcommands({})) {
    if (CLI::Option* const output = verb->get_option_no_throw("--output")) output->check(output_name());
  }
  try {
    const int code = run_verb(command, exit_code, argc, argv);
    require_printed();
    return code;
  } catch (const std::exception& error) {
    return report(error.what(), exit_code_of(error));
  }
}

}  // namespace mapless::app
