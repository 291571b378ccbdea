#include <filesystem>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/result_evaluation.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace {

using Mask = std::vector<std::uint8_t>;

// 1 for the records whose return is within the range; empty, which masks nothing, without a limit.
Mask range_mask(const Dataset& dataset, std::size_t scan_number, const std::optional<double>& max_range_m) {
  if (!max_range_m) return {};
  const LidarScan scan = dataset.read(scan_number);
  Mask mask(scan.input_size, 0);
  for (const LidarReturn& r : scan.returns) {
    if (static_cast<double>(r.range_m) <= *max_range_m) mask[r.input_index] = 1;
  }
  return mask;
}

Mask dynamic_labels(const std::vector<std::uint32_t>& labels) {
  Mask mask(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    mask[i] = motion_of_label(labels[i]) == MotionTruth::moving ? 1 : 0;
  }
  return mask;
}

Mask bit_of(const Mask& masks, int bit) {
  Mask out(masks.size());
  for (std::size_t i = 0; i < masks.size(); ++i) out[i] = static_cast<std::uint8_t>(masks[i] >> bit & 1u);
  return out;
}

void evaluate_scan(const Dataset& dataset, const ResultFolder& result, std::size_t scan,
                   const std::vector<std::uint32_t>& truth, const EvaluationOptions& options,
                   ResultEvaluation& out) {
  const Mask counted = range_mask(dataset, scan, options.max_range_m);
  const auto labels = read_label_file(result.label_file(scan), truth.size());
  out.report.points.add(count_points(truth, dynamic_labels(labels), counted));
  if (!std::filesystem::exists(result.stage_file(scan))) return;
  const Mask masks = read_stage_file(result.stage_file(scan), truth.size());
  for (int s = 0; s < options.stages; ++s) {
    out.after_stage[static_cast<std::size_t>(s)].add(count_points(truth, bit_of(masks, s), counted));
  }
}

}  // namespace

ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                 const EvaluationOptions& options) {
  const std::vector<std::size_t> scans = result.labelled_scans();
  ResultEvaluation out;
  out.labelled_scans = scans.size();
  out.after_stage.resize(static_cast<std::size_t>(options.stages));
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i] >= dataset.size()) {
      throw InputError({result.label_file(scans[i]).string(), "scan", std::to_string(scans[i]),
                        fmt::format("the recording has scans 0 to {} only", dataset.size() - 1),
                        "give the recording this result was made from"});
    }
    if (const auto truth = dataset.read_labels(scans[i])) {
      out.scans.push_back(scans[i]);
      evaluate_scan(dataset, result, scans[i], *truth, options, out);
    } else {
      ++out.scans_without_truth;
    }
    if (options.progress) options.progress(i + 1, scans.size());
  }
  if (out.scans.empty()) {
    throw InputError({result.labels().string(), "scans", std::to_string(scans.size()),
                      "none has both a label file and a truth in the recording",
                      "give the folder of true labels with --labels"});
  }
  return out;
}

}  // namespace mapless
