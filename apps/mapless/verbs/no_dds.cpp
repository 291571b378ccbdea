// The verb live in a build without Cyclone DDS.
#include <CLI/CLI.hpp>

#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {

void refuse_live(CLI::App& app, int& /*exit_code*/) {
  CLI::App* verb = app.add_subcommand("live", "Not in this build: it has no Cyclone DDS");
  verb->allow_extras();
  verb->callback([] {
    throw Error({"mapless live", "", "", "this build has no DDS: Cyclone DDS 0.10 was not found",
                 "install it (Debian, Ubuntu: cyclonedds-dev and cyclonedds-tools) and build again"});
  });
}

}  // namespace mapless::app
