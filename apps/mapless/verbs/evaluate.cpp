#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_checks.hpp"
#include "options/output_file.hpp"
#include "options/recording_options.hpp"
#include "reports/evaluation_json.hpp"
#include "reports/evaluation_tables.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "reports/method_of_result.hpp"
#include "reports/trajectory_comparison.hpp"
#include "reports/trajectory_tables.hpp"
#include "terminal/progress.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

struct EvaluateOptions {
  RecordingOptions recording;
  std::string result;
  TrajectoryComparison trajectory;
  std::optional<double> max_range_m;
  bool partial = false;
  std::string json;
};

// Of a result of mapless detect or odometry; other folders of labels do not say what belongs to them.
void require_whole(const ResultFolder& result) {
  if (!std::filesystem::exists(result.summary())) return;
  const Json summary = Json::parse(read_whole_file(result.summary()), nullptr, false);
  if (!summary.is_object()) {
    throw InputError({result.summary().string(), "", "", "is damaged: not a JSON object",
                      "make the result again, or remove the file to evaluate what is there"});
  }
  const Json program = summary.value("program", Json());
  if (program != kProgramName && program != kOdometryProgramName) return;
  const auto refuse = [&result](const std::string& field, const std::string& value,
                                const std::string& problem) {
    throw InputError(
        {result.summary().string(), field, value, problem,
         "run it to its end (--resume), or give --partial to evaluate the scans that are there"});
  };
  if (summary.value("complete", Json()) != true)
    refuse("complete", "false", "the run was ended before its last scan");
  if (program != kProgramName) return;
  const std::size_t files = result.labelled_scans().size();
  if (summary.value("scans", Json()) != files)
    refuse("scans", summary.value("scans", Json()).dump(), fmt::format("there are {} label files", files));
}

std::string table_row(std::string_view name, const PrecisionRecall& r) {
  const Counts& c = r.total();
  return fmt::format("{:<22}{:>10}{:>8}{:>12}{:>6}{:>9}{:>6}{:>8}{:>8}{:>10}{:>10}{:>10}{:>12}\n", name,
                     rate_text(c.precision()), rate_text(c.recall()), rate_text(r.average_precision()),
                     r.precision_scans(), rate_text(r.average_recall()), r.recall_scans(), rate_text(c.f1()),
                     rate_text(c.iou()), c.tp, c.fp, c.fn, c.tn);
}

std::string table(const ResultEvaluation& e, const StageNames& names,
                  const std::optional<double>& max_range_m) {
  std::string out =
      fmt::format("{} scans evaluated of {} labelled ({} have no true labels); points {}\n\n", e.scans.size(),
                  e.labelled_scans, e.scans_without_truth,
                  max_range_m ? fmt::format("within {} m of their laser", *max_range_m) : "at all ranges");
  out += fmt::format("{:<22}{:>18}{:>33}{:>16}{:>42}\n", "", "total [0..1]", "average over scans [0..1]",
                     "moving [0..1]", "points");
  out += fmt::format("{:<22}{:>10}{:>8}{:>12}{:>6}{:>9}{:>6}{:>8}{:>8}{:>10}{:>10}{:>10}{:>12}\n", "after",
                     "precision", "recall", "precision", "N_p", "recall", "N_r", "F1", "IoU", "TP", "FP",
                     "FN", "TN");
  for (std::size_t s = 0; s < e.after_stage.size(); ++s) {
    if (e.after_stage[s].scans() > 0) out += table_row(names.at(s), e.after_stage[s]);
  }
  return out + table_row("final labels", e.report.points);
}

Json named_json(std::string_view name, const PrecisionRecall& rates) {
  Json out = {{"name", name}};
  out.update(to_json(rates));
  return out;
}

Json result_json(const ResultEvaluation& e, const StageNames& names,
                 const std::optional<double>& max_range_m) {
  Json stages = Json::array();
  for (std::size_t s = 0; s < e.after_stage.size(); ++s) {
    if (e.after_stage[s].scans() > 0) stages.push_back(named_json(names.at(s), e.after_stage[s]));
  }
  return {{"scans", e.scans.size()},
          {"labelled_scans", e.labelled_scans},
          {"scans_without_truth", e.scans_without_truth},
          {"max_range_m", max_range_m ? Json(*max_range_m) : Json(nullptr)},
          {"stages", stages},
          {"final", named_json("final labels", e.report.points)},
          {"report", to_json(e.report)},
          {"sight", to_json(e.sight)},
          {"delays", e.delays ? to_json(*e.delays) : Json(nullptr)},
          {"velocity", e.velocity ? to_json(*e.velocity) : Json(nullptr)}};
}

// The tables of the true objects lie beside the true labels.
std::filesystem::path objects_folder(const RecordingOptions& recording) {
  if (recording.dataset.labels.empty()) return recording.path;
  return std::filesystem::absolute(recording.dataset.labels / "")
      .lexically_normal()
      .parent_path()
      .parent_path();
}

ResultEvaluation evaluate_labels(const Dataset& dataset, const EvaluateOptions& options) {
  EvaluationOptions how;
  how.stages = kStageCount;
  how.max_range_m = options.max_range_m;
  how.objects = objects_folder(options.recording);
  Progress progress("scans");
  how.progress = [&progress](std::size_t done, std::size_t of) { progress.update(done, of); };
  ResultEvaluation evaluation = evaluate_result(dataset, ResultFolder(options.result), how);
  progress.clear();
  return evaluation;
}

// A result without labels, or of a recording without true labels, is evaluated by its trajectory alone.
bool has_labels_to_evaluate(const Dataset& dataset, const std::filesystem::path& result) {
  if (!std::filesystem::is_directory(ResultFolder(result).labels())) return false;
  const auto scans = ResultFolder(result).labelled_scans();
  return std::any_of(scans.begin(), scans.end(), [&](std::size_t k) {
    return k >= dataset.size() || dataset.read_labels(k).has_value();
  });
}

int evaluate(const EvaluateOptions& options) {
  require_not_input(options.json, options.recording.path, options.result);
  const auto dataset = options.recording.open();
  const std::filesystem::path result = options.result;
  if (!options.partial) require_whole(ResultFolder(result));
  if (std::filesystem::exists(result) && !std::filesystem::is_directory(result) &&
      options.trajectory.reference.file.empty() && !dataset->trajectory()) {
    throw InputError({options.recording.path, "trajectory", "",
                      "the recording has no true trajectory to compare with", "give --reference-trajectory"});
  }
  const auto trajectory = compare_trajectory(*dataset, result, options.trajectory);
  std::optional<ResultEvaluation> labels;
  if (!trajectory || has_labels_to_evaluate(*dataset, result)) labels = evaluate_labels(*dataset, options);
  const StageNames stages = stage_names_of(ResultFolder(result));
  Json figures = labels ? result_json(*labels, stages, options.max_range_m) : Json::object();
  figures["trajectory"] = trajectory ? to_json(*trajectory) : Json(nullptr);
  if (options.json == "-") {
    fmt::print("{}", json_text(figures));
    return 0;
  }
  if (!options.json.empty()) write_file_atomically(options.json, json_text(figures));
  if (labels) {
    fmt::print("{}{}{}", table(*labels, stages, options.max_range_m), report_tables(labels->report),
               hard_case_lines(labels->sight, labels->delays));
  }
  if (labels && labels->velocity) fmt::print("{}", velocity_lines(*labels->velocity));
  if (trajectory) fmt::print("{}", trajectory_tables(*trajectory));
  return 0;
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "evaluate",
      "Compare a result with the truth of the recording. Labels: precision, recall, F1 and IoU after each "
      "stage, and by range, class, speed and number of visible points; objects found; points seen through a "
      "fence, points with only sky behind; delay of starts and stops; errors of the velocity of tracked "
      "objects. Trajectory: drift (KITTI), absolute and relative errors (as in evo), displacement "
      "of static points");
  const auto options = std::make_shared<EvaluateOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option(
          "OUT", options->result,
          "result of mapless detect or odometry, a folder with labels/NNNNNN.label, or a trajectory file "
          "(TUM rows or KITTI rows, world from sensor)")
      ->required();
  verb->add_option("--max-range", options->max_range_m,
                   "leave out points farther than this from their laser [m]")
      ->check(positive_number());
  verb->add_flag("--partial", options->partial,
                 "evaluate a result that was ended before its last scan, or has lost label files");
  add_reference_trajectory_options(*verb, options->trajectory.reference);
  add_pose_instant_option(
      *verb, options->trajectory.result_instant,
      "where OUT is a file of KITTI rows: the instant within the scan that each pose is at");
  verb->add_option("--json", options->json,
                   "JSON file to write the figures to; - prints JSON in place of the tables");
  verb->callback([options, &exit_code] { exit_code = evaluate(*options); });
}

}  // namespace mapless::app
