#pragma once

#include <CLI/App.hpp>

namespace mapless::app {

/// Each adds its verb with all options to `app`; when the command line names the verb, it runs while the line
/// is parsed and leaves what the process is to exit with in `exit_code`. Errors are thrown.
void add_detect(CLI::App& app, int& exit_code);
void add_odometry(CLI::App& app, int& exit_code);
void add_evaluate(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_view(CLI::App& app, int& exit_code);
void add_explain(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_config(CLI::App& app, int& exit_code);
void add_benchmark(CLI::App& app, int& exit_code);
/// The verb live where there is no DDS.
void refuse_live(CLI::App& app, int& exit_code);

using AddVerb = void (*)(CLI::App& app, int& exit_code);

/// Of the Python package, whose command handles it before this one: says so.
void add_batch(CLI::App& app);

}  // namespace mapless::app
