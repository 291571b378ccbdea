#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::inline v1 {

/// The labels of a result folder compared with the truth of its recording.
struct ResultEvaluation {
  std::size_t labelled_scans = 0;            ///< scans with a label file in the folder
  std::size_t scans_without_truth = 0;       ///< of these, the scans without true labels
  std::vector<std::size_t> scans;            ///< those that are evaluated: with both
  std::vector<PrecisionRecall> after_stage;  ///< by stage, over the evaluated scans that have a stage file
  EvaluationReport report;                   ///< of the final labels
  SightReport sight;                         ///< of the final labels
  std::optional<DelayReport> delays;         ///< absent if the recording has no object_states.csv
  /// Of the tracked objects; absent if the recording has no object_states.csv, or the folder no summary.json,
  /// which marks a result of mapless detect.
  std::optional<VelocityReport> velocity;
};

struct EvaluationOptions {
  int stages = 0;                     ///< number of bits used in a stage file, 0 to 8
  std::optional<double> max_range_m;  ///< points farther from their laser do not count; above 0
  std::filesystem::path objects;      ///< folder of objects.csv and object_states.csv; empty: none
  std::function<void(std::size_t done, std::size_t of)> progress;  ///< called after every scan; may be empty
};

/// Evaluates every scan of `result` that has true labels in `dataset`. Throws ParameterError for options out
/// of bounds, InputError for files that do not fit the recording, and if no scan has both label and truth.
[[nodiscard]] ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                               const EvaluationOptions& options);

}  // namespace mapless
