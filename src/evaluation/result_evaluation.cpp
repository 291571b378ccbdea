#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include "evaluation/label_alignment.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

using Mask = std::vector<std::uint8_t>;

// 1 for records with a return within the range limit; empty (every record counts) without a limit.
Mask range_mask(const std::vector<float>& ranges_m, const std::optional<double>& max_range_m) {
  if (!max_range_m) return {};
  Mask mask(ranges_m.size(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (static_cast<double>(ranges_m[i]) <= *max_range_m) mask[i] = 1;
  }
  return mask;
}

Mask bit_of(const Mask& masks, int bit) {
  Mask out(masks.size());
  for (std::size_t i = 0; i < masks.size(); ++i) out[i] = static_cast<std::uint8_t>(masks[i] >> bit & 1u);
  return out;
}

// States are numbered by scan. If scans were removed from the recording, the numbers refer to other scans.
void require_states_of(const Dataset& dataset, const ObjectTruth& objects,
                       const std::filesystem::path& folder) {
  for (const auto& [key, state] : objects.states) {
    const auto& [scan, id] = key;
    if (scan >= dataset.size()) continue;
    if (state.time >= dataset.scan_start(scan) && state.time <= dataset.scan_end(scan)) continue;
    throw InputError({(folder / "object_states.csv").string(), fmt::format("scan {}, object {}", scan, id),
                      fmt::format("{} s", state.time.seconds()), "not during that scan of the recording",
                      "give the whole recording the table was written with, or remove the table"});
  }
}

// Evaluates the velocities, and knows the rotation between the world frames of result and truth.
class VelocityEvaluation {
 public:
  VelocityEvaluation(const Dataset& dataset, const ResultFolder& result, const ObjectTruth& truth,
                     const std::optional<double>& max_range_m) {
    // A folder without summary.json is no result of mapless detect: label files only, or a recording, whose
    // objects.csv is another table.
    if (!truth.has_states || !std::filesystem::exists(result.summary())) return;
    evaluator_.emplace(truth, read_object_table(result.objects()), result.objects().string(), max_range_m);
    if (!std::filesystem::exists(result.trajectory())) return;
    true_trajectory_ = dataset.trajectory();
    trajectory_.emplace(read_trajectory_file(result.trajectory(), {}));
  }

  void add(const ScanLabels& scan, Time start) {
    if (evaluator_) evaluator_->add(scan, C_rt(start));
  }
  [[nodiscard]] std::optional<VelocityReport> report() const {
    if (!evaluator_) return std::nullopt;
    return evaluator_->report();
  }

 private:
  // From the orientation of the sensor in both.
  [[nodiscard]] Eigen::Matrix3d C_rt(Time time) const {
    if (!trajectory_ || !true_trajectory_) return Eigen::Matrix3d::Identity();
    return trajectory_->at(time).T_v0.rotation().transpose() * true_trajectory_->at(time).T_v0.rotation();
  }

  std::optional<VelocityEvaluator> evaluator_;
  std::optional<SampledTrajectory> trajectory_;
  std::shared_ptr<const Trajectory> true_trajectory_;
};

// Everything that is accumulated over the scans.
struct Evaluators {
  Evaluator labels;
  SightEvaluator sight;
  DelayEvaluator delays;
  VelocityEvaluation velocity;
  LabelAlignment alignment;

  void add(const ScanLabels& labels_of_scan, const LidarScan& scan) {
    labels.add(labels_of_scan);
    sight.add(scan, labels_of_scan);
    delays.add(labels_of_scan);
    velocity.add(labels_of_scan, scan.start);
    alignment.add(labels_of_scan);
  }
  void report(ResultEvaluation& out) const {
    out.report = labels.report();
    out.sight = sight.report();
    out.delays = delays.report();
    out.velocity = velocity.report();
  }
};

void evaluate_scan(const Dataset& dataset, const ResultFolder& result, std::size_t scan,
                   const std::vector<std::uint32_t>& truth, const EvaluationOptions& options,
                   Evaluators& evaluators, ResultEvaluation& out) {
  const LidarScan measured = dataset.read(scan);
  const std::vector<float> ranges = ranges_of(measured);
  const auto labels = read_label_file(result.label_file(scan), truth.size());
  evaluators.add({scan, truth, labels, ranges}, measured);
  if (!std::filesystem::exists(result.stage_file(scan))) return;
  const Mask masks = read_stage_file(result.stage_file(scan), truth.size());
  const Mask counted = range_mask(ranges, options.max_range_m);
  for (int s = 0; s < options.stages; ++s) {
    out.after_stage[static_cast<std::size_t>(s)].add(count_points(truth, bit_of(masks, s), counted));
  }
}

}  // namespace

ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                 const EvaluationOptions& options) {
  require_between("evaluate_result", "stages", options.stages, 0, 8);
  const std::vector<std::size_t> scans = result.labelled_scans();
  ResultEvaluation out;
  out.labelled_scans = scans.size();
  out.after_stage.resize(static_cast<std::size_t>(options.stages));
  ObjectTruth objects;
  if (!options.objects.empty()) objects = read_object_truth(options.objects);
  require_states_of(dataset, objects, options.objects);
  const auto& limit = options.max_range_m;
  Evaluators evaluators{Evaluator(objects, limit), SightEvaluator(limit), DelayEvaluator(objects, limit),
                        VelocityEvaluation(dataset, result, objects, limit), LabelAlignment()};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i] >= dataset.size()) {
      throw InputError({result.label_file(scans[i]).string(), "scan", std::to_string(scans[i]),
                        fmt::format("the recording has scans 0 to {} only", dataset.size() - 1),
                        "give the recording this result was made from"});
    }
    if (const auto truth = dataset.read_labels(scans[i])) {
      out.scans.push_back(scans[i]);
      evaluate_scan(dataset, result, scans[i], *truth, options, evaluators, out);
    } else {
      ++out.scans_without_truth;
    }
    if (options.progress) options.progress(i + 1, scans.size());
  }
  if (out.scans.empty()) {
    throw InputError({result.labels().string(), "scans", std::to_string(scans.size()),
                      "none has both a label file and true labels in the recording",
                      "give the folder of true labels with --labels"});
  }
  evaluators.alignment.require(result);
  evaluators.report(out);
  return out;
}

}  // namespace mapless
