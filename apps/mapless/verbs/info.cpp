#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/recording_options.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "run/run_summary.hpp"
#include "terminal/progress.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {
namespace {

struct InfoOptions {
  RecordingOptions recording;
  bool json = false;
};

Json trajectory_json(const Dataset& dataset) {
  try {
    const auto trajectory = dataset.trajectory();
    if (!trajectory) return nullptr;
    require_coverage(dataset, *trajectory, 0, dataset.size());
    return {{"begin_s", trajectory->begin().seconds()}, {"end_s", trajectory->end().seconds()}};
  } catch (const Error& error) {
    return {{"error", error.what()}};
  }
}

Json estimate_json(const Dataset& dataset) {
  const auto estimate = dataset.model_estimate();
  if (!estimate) return nullptr;
  return {{"scans_used", estimate->scans_used},
          {"elevation_residual_m", estimate->elevation_residual_m},
          {"azimuth_residual_columns", estimate->azimuth_residual_columns}};
}

// Along the poses of the recording, where they cover it.
std::vector<CheckResult> self_check(const Dataset& dataset) {
  std::shared_ptr<const Trajectory> given;
  try {
    given = dataset.trajectory();
    if (given) require_coverage(dataset, *given, 0, dataset.size());
  } catch (const Error&) {  // trajectory_line says so
    given = nullptr;
  }
  return check_recording(dataset, given, 0, dataset.size());
}

Json to_json(const std::vector<CheckResult>& checks) {
  Json out = Json::array();
  for (const CheckResult& c : checks) {
    out.push_back({{"name", c.name},
                   {"trust", name_of(c.trust)},
                   {"measured", c.measured},
                   {"where", c.where},
                   {"problem", c.problem},
                   {"remedy", c.remedy}});
  }
  return out;
}

Json to_json(const Dataset& dataset, const RecordingSurvey& s, const std::vector<CheckResult>& checks) {
  const auto model = dataset.model();
  return {{"format", dataset.format()},
          {"sensor",
           {{"name", model->name},
            {"lasers", model->lasers.size()},
            {"columns", model->columns},
            {"rotation_rate_hz", model->rotation_rate_hz},
            {"estimate", estimate_json(dataset)}}},
          {"scans", s.scans},
          {"readable_scans", s.readable_scans},
          {"begin_s", s.begin.seconds()},
          {"end_s", s.end.seconds()},
          {"median_period_s", s.median_period_s},
          {"times", provenance_text(s.time_source)},
          {"rings", provenance_text(s.ring_source)},
          {"motion_compensated", s.compensated},
          {"compensated_to_fraction", s.compensated ? Json(s.compensated_to_fraction) : Json(nullptr)},
          {"trajectory", trajectory_json(dataset)},
          {"records", s.records},
          {"points", s.returns},
          {"points_per_scan", {{"min", s.min_returns}, {"median", s.median_returns}, {"max", s.max_returns}}},
          {"no_return_faulty_or_unknown", s.faulty},
          {"no_return_nothing_within_range", s.nothing},
          {"unusable_records", s.unusable},
          {"labels",
           {{"scans", s.labelled_scans},
            {"moving_points", s.moving_points},
            {"static_points", s.still_points},
            {"unknown_points", s.unknown_points}}},
          {"self_check", to_json(checks)},
          {"oddities", s.oddities},
          {"notes", dataset.notes()}};
}

std::string trajectory_line(const Json& trajectory, bool compensated) {
  if (trajectory.is_null())
    return compensated ? "none: detect needs --trajectory FILE to undo the compensation"
                       : "none: detect estimates it from the points (lidar odometry)";
  if (trajectory.contains("error"))
    return "does not cover the whole recording, or cannot be read: " + trajectory["error"].get<std::string>();
  return fmt::format("in the recording, {:.3f} to {:.3f} s", trajectory["begin_s"].get<double>(),
                     trajectory["end_s"].get<double>());
}

std::string sensor_line(const Dataset& dataset) {
  const auto model = dataset.model();
  std::string line = fmt::format("{}, {} lasers x {} columns at {:g} Hz", model->name, model->lasers.size(),
                                 model->columns, model->rotation_rate_hz);
  if (const auto estimate = dataset.model_estimate()) {
    line += fmt::format(
        "; estimated from {} scans, residual {:.2f} mm in elevation, {:.2f} columns in azimuth",
        estimate->scans_used, 1e3 * estimate->elevation_residual_m, estimate->azimuth_residual_columns);
  }
  return line;
}

std::string lines(const Dataset& dataset, const RecordingSurvey& s, const std::vector<CheckResult>& checks) {
  std::string out;
  const auto line = [&out](std::string_view name, const std::string& text) {
    out += fmt::format("{:<14}{}\n", name, text);
  };
  line("format", dataset.format());
  line("sensor", sensor_line(dataset));
  line("scans", s.readable_scans == s.scans
                    ? fmt::format("{}", s.scans)
                    : fmt::format("{}, {} of them readable", s.scans, s.readable_scans));
  line("times", fmt::format("{:.3f} to {:.3f} s, {:.4f} s a scan; of points: {}", s.begin.seconds(),
                            s.end.seconds(), s.median_period_s, provenance_text(s.time_source)));
  line("rings", provenance_text(s.ring_source));
  line("compensation", s.compensated
                           ? fmt::format("motion-compensated to {:.0f} % of the scan; detect undoes it",
                                         100 * s.compensated_to_fraction)
                           : "none: points are where they were measured");
  line("trajectory", trajectory_line(trajectory_json(dataset), s.compensated));
  line("points", fmt::format("{}; {} to {} a scan, median {}", s.returns, s.min_returns, s.max_returns,
                             s.median_returns));
  line("no return",
       fmt::format("{} faulty or unknown (NaN included), {} with nothing within range, {} unusable records",
                   s.faulty, s.nothing, s.unusable));
  line("labels", s.labelled_scans == 0
                     ? "none"
                     : fmt::format("{} scans; {} moving, {} static, {} unknown points", s.labelled_scans,
                                   s.moving_points, s.still_points, s.unknown_points));
  for (const CheckResult& c : checks) {
    line("check", c.trust == Trust::unknown
                      ? fmt::format("{}: {}", c.name, c.measured)
                      : fmt::format("{}: {}: {}", c.name, name_of(c.trust), c.measured));
    if (!c.problem.empty()) line("", fmt::format("{}: {}; {}", c.where, c.problem, c.remedy));
  }
  for (const std::string& note : dataset.notes()) line("note", note);
  for (const std::string& oddity : s.oddities) line("odd", oddity);
  if (s.oddities.empty()) line("odd", "nothing");
  return out;
}

int info(const InfoOptions& options) {
  const auto dataset = options.recording.open();
  Progress progress("scans");
  const RecordingSurvey survey = survey_recording(
      *dataset, [&progress](std::size_t done, std::size_t of) { progress.update(done, of); });
  progress.clear();
  const std::vector<CheckResult> checks = self_check(*dataset);
  if (options.json) {
    fmt::print("{}", json_text(to_json(*dataset, survey, checks)));
  } else {
    fmt::print("{}", lines(*dataset, survey, checks));
  }
  return 0;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "info",
      "Print the contents of a recording, where its times and rings come from, and what is unusual in it");
  const auto options = std::make_shared<InfoOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &exit_code] { exit_code = info(*options); });
}

}  // namespace mapless::app
