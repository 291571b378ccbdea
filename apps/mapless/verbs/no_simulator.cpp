// The verbs that need the simulator, in a build that has none.
#include <string>

#include <CLI/CLI.hpp>

#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

void refuse(CLI::App& app, const std::string& verb) {
  CLI::App* command = app.add_subcommand(verb, "Not in this build: it has no simulator");
  command->allow_extras();
  command->callback([verb] {
    throw Error({"mapless " + verb, "", "", "this build has no simulator: Embree was not found",
                 "install Embree 3 or 4 (Debian, Ubuntu: libembree-dev) and build again"});
  });
}

}  // namespace

void add_simulate(CLI::App& app, int& /*exit_code*/) { refuse(app, "simulate"); }
void add_benchmark(CLI::App& app, int& /*exit_code*/) { refuse(app, "benchmark"); }

}  // namespace mapless::app
