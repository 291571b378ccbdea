#include <CLI/CLI.hpp>

#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {

void add_batch(CLI::App& app) {
  CLI::App* verb = app.add_subcommand(
      "batch",
      "Label many recordings, on one machine or a cluster: plan, run, merge (Python package, docs/fleet.md)");
  verb->allow_extras();
  verb->callback([] {
    throw ParameterError({"mapless batch", "", "",
                          "a verb of the Python package, whose command has all verbs",
                          "pip install 'mapless[batch]' from a checkout (docs/fleet.md)"});
  });
}

}  // namespace mapless::app
