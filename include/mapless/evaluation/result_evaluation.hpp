#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <mapless/evaluation/evaluation_report.hpp>
#include <mapless/evaluation/velocity_evaluator.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::inline v1 {

/// How well the labels of a result folder agree with the truth of its recording.
struct ResultEvaluation {
  std::size_t labelled_scans = 0;            ///< scans of the folder
  std::size_t scans_without_truth = 0;       ///< of these, the ones that cannot count
  std::vector<std::size_t> scans;            ///< those that count: label and truth are both there
  std::vector<PrecisionRecall> after_stage;  ///< by stage; over the scans of `scans` that have a stage file
  EvaluationReport report;                   ///< of the final labels
  /// Of the objects followed over time; absent where the recording has no object_states.csv, or the folder is
  /// no result of mapless detect (it has no summary.json).
  std::optional<VelocityReport> velocity;
};

struct EvaluationOptions {
  int stages = 0;                     ///< bits used in a stage file
  std::optional<double> max_range_m;  ///< points farther from their laser do not count
  std::filesystem::path objects;      ///< folder of objects.csv and object_states.csv; empty: there are none
  std::function<void(std::size_t done, std::size_t of)> progress;
};

/// Throws InputError for files that do not fit the recording, or where no scan has both label and truth.
[[nodiscard]] ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                               const EvaluationOptions& options);

}  // namespace mapless
