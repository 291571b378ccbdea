#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "explain/point_report.hpp"
#include "explain/replayed_run.hpp"
#include "options/option_checks.hpp"
#include "options/recording_options.hpp"
#include "terminal/progress.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

struct ExplainOptions {
  RecordingOptions recording;
  std::string result;
  GivenAgain given;
  std::size_t scan = 0, point = 0;
  bool json = false;
};

// The return with this number in the input.
std::size_t return_of(const LidarScan& scan, const ExplainOptions& options) {
  const auto found = std::find_if(scan.returns.begin(), scan.returns.end(),
                                  [&](const LidarReturn& r) { return r.input_index == options.point; });
  if (found != scan.returns.end()) return static_cast<std::size_t>(found - scan.returns.begin());
  throw ParameterError({"--point", "", std::to_string(options.point),
                        options.point < scan.input_size ? "has no return" : "no such point",
                        fmt::format("scan {} has points 0 to {}, {} with a return", options.scan,
                                    scan.input_size - 1, scan.returns.size())});
}

// The decisions of all scans about the object of the point, once its scan is labelled.
class PointFinder {
 public:
  explicit PointFinder(const ExplainOptions& options) : options_(options) {}

  void take(std::size_t k, const LabelledScan& scan) {
    const auto& explanation = scan.detection.explanation;
    if (explanation) objects_[k] = explanation->objects;
    if (k != options_.scan) return;
    labelled_ = scan;
    if (!explanation) {
      throw InputError({options_.result, "", fmt::format("scan {}", k), "has no labels: its motion is lost",
                        "give --trajectory to mapless detect"});
    }
  }

  [[nodiscard]] ExplainedPoint point() const {
    ExplainedPoint out{options_.scan, return_of(labelled_->scan(), options_), &*labelled_, {}};
    const std::uint16_t proposed = labelled_->detection.explanation->points[out.at].proposed;
    if (proposed == 0) return out;
    const std::uint32_t track = objects_.at(options_.scan).at(proposed - 1U).track;
    for (const auto& [k, objects] : objects_) {
      for (const ObjectDecision& one : objects) {
        if (one.track == track) out.history.emplace(k, one);
      }
    }
    return out;
  }

 private:
  const ExplainOptions& options_;
  std::map<std::size_t, std::vector<ObjectDecision>> objects_;
  std::optional<LabelledScan> labelled_;
};

int explain(const ExplainOptions& options) {
  const auto dataset = options.recording.open();
  const ResultFolder result(options.result);
  const ReplayedRun run(*dataset, result, options.given);
  if (options.scan < run.first() || options.scan >= run.first() + run.count()) {
    throw ParameterError({"--scan", "", std::to_string(options.scan), "is not in the result",
                          fmt::format("it has scans {} to {}", run.first(), run.first() + run.count() - 1)});
  }
  PointFinder finder(options);
  Progress progress("scans");
  run.run(
      options.scan, [&](std::size_t k) { return k == options.scan; },
      [&](std::size_t k, const LabelledScan& scan) {
        finder.take(k, scan);
        progress.update(k - run.first() + 1, options.scan - run.first() + 1);
      });
  progress.clear();
  const Json point = point_json(finder.point(), run.parameters().detector.voting);
  fmt::print("{}", options.json ? point.dump(2) + "\n" : point_text(point));
  return 0;
}

}  // namespace

void add_explain(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "explain",
      "Say why a point of a result is dynamic or static: what the rays of each earlier and later scan saw at "
      "its place, which step decided, with numbers and limits, and the history of its object. Runs the "
      "detector again up to that scan, and compares the labels with those of the result");
  const auto options = std::make_shared<ExplainOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("OUT", options->result, "result of mapless detect, of this version")->required();
  verb->add_option("--scan", options->scan, "number of the scan, from 0")->required()->check(whole_number(0));
  verb->add_option("--point", options->point,
                   "number of the point in the input, from 0: the page of mapless view names it on a click")
      ->required()
      ->check(whole_number(0));
  add_trajectory_options(*verb, options->given.trajectory);
  add_motion_measurement_options(*verb, options->given.measured);
  verb->add_flag("--json", options->json, "print JSON with every figure");
  verb->callback([options, &exit_code] { exit_code = explain(*options); });
}

}  // namespace mapless::app
