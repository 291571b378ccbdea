#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "evaluation_json.hpp"
#include "evaluation_tables.hpp"
#include "json_text.hpp"
#include "option_checks.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "verbs.hpp"
#include <mapless/detection/stages.hpp>
#include <mapless/evaluation/result_evaluation.hpp>
#include <mapless/io/atomic_file.hpp>

namespace mapless::app {
namespace {

using Json = nlohmann::ordered_json;

struct EvaluateOptions {
  RecordingOptions recording;
  std::string result;
  std::optional<double> max_range_m;
  std::string json;
};

std::string rate_text(const std::optional<double>& rate) { return rate ? fmt::format("{:.3f}", *rate) : "-"; }

std::string table_row(std::string_view name, const PrecisionRecall& r) {
  const Counts& c = r.total();
  return fmt::format("{:<22}{:>10}{:>8}{:>12}{:>6}{:>9}{:>6}{:>8}{:>8}{:>10}{:>10}{:>10}{:>12}\n", name,
                     rate_text(c.precision()), rate_text(c.recall()), rate_text(r.average_precision()),
                     r.precision_scans(), rate_text(r.average_recall()), r.recall_scans(), rate_text(c.f1()),
                     rate_text(c.iou()), c.tp, c.fp, c.fn, c.tn);
}

std::string table(const ResultEvaluation& e, const std::optional<double>& max_range_m) {
  std::string out = fmt::format(
      "{} scans count (label and truth both there) of {} labelled ({} without truth); points {}\n\n",
      e.scans.size(), e.labelled_scans, e.scans_without_truth,
      max_range_m ? fmt::format("within {} m of their laser", *max_range_m) : "at all ranges");
  out += fmt::format("{:<22}{:>18}{:>33}{:>16}{:>42}\n", "", "total [0..1]", "average over scans [0..1]",
                     "moving [0..1]", "points");
  out += fmt::format("{:<22}{:>10}{:>8}{:>12}{:>6}{:>9}{:>6}{:>8}{:>8}{:>10}{:>10}{:>10}{:>12}\n", "after",
                     "precision", "recall", "precision", "N_p", "recall", "N_r", "F1", "IoU", "TP", "FP",
                     "FN", "TN");
  for (std::size_t s = 0; s < e.after_stage.size(); ++s) {
    if (e.after_stage[s].scans() > 0) out += table_row(kStageNames.at(s), e.after_stage[s]);
  }
  return out + table_row("final labels", e.report.points);
}

Json named_json(std::string_view name, const PrecisionRecall& rates) {
  Json out = {{"name", name}};
  out.update(to_json(rates));
  return out;
}

Json result_json(const ResultEvaluation& e, const std::optional<double>& max_range_m) {
  Json stages = Json::array();
  for (std::size_t s = 0; s < e.after_stage.size(); ++s) {
    if (e.after_stage[s].scans() > 0) stages.push_back(named_json(kStageNames.at(s), e.after_stage[s]));
  }
  return {{"scans", e.scans.size()},
          {"labelled_scans", e.labelled_scans},
          {"scans_without_truth", e.scans_without_truth},
          {"max_range_m", max_range_m ? Json(*max_range_m) : Json(nullptr)},
          {"stages", stages},
          {"final", named_json("final labels", e.report.points)},
          {"report", to_json(e.report)}};
}

// The tables of objects belong to the true labels.
std::filesystem::path objects_folder(const RecordingOptions& recording) {
  if (recording.dataset.labels.empty()) return recording.path;
  return std::filesystem::absolute(recording.dataset.labels / "")
      .lexically_normal()
      .parent_path()
      .parent_path();
}

int evaluate(const EvaluateOptions& options) {
  const auto dataset = options.recording.open();
  EvaluationOptions how;
  how.stages = kStageCount;
  how.max_range_m = options.max_range_m;
  how.objects = objects_folder(options.recording);
  Progress progress("scans");
  how.progress = [&progress](std::size_t done, std::size_t of) { progress.update(done, of); };
  const ResultEvaluation evaluation = evaluate_result(*dataset, ResultFolder(options.result), how);
  progress.clear();
  const std::string json = json_text(result_json(evaluation, options.max_range_m));
  if (options.json == "-") {
    fmt::print("{}", json);
    return 0;
  }
  if (!options.json.empty()) write_file_atomically(options.json, json);
  fmt::print("{}{}", table(evaluation, options.max_range_m), report_tables(evaluation.report));
  return 0;
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto* verb =
      app.add_subcommand("evaluate",
                         "Compare a result with the true labels: precision, recall, F1 and IoU after each "
                         "stage; by range, class, speed and visible points; objects found");
  const auto options = std::make_shared<EvaluateOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("OUT", options->result,
                   "the result of mapless detect, or a folder with labels/NNNNNN.label")
      ->required();
  verb->add_option("--max-range", options->max_range_m,
                   "points farther than this from their laser do not count [m]")
      ->check(positive_number());
  verb->add_option("--json", options->json,
                   "also write the figures to this file; - prints them instead of the table");
  verb->callback([options, &exit_code] { exit_code = evaluate(*options); });
}

}  // namespace mapless::app
