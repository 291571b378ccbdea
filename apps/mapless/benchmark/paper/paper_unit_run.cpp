#include "benchmark/paper/paper_unit_run.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "benchmark/ablated_motion.hpp"
#include "benchmark/movers/mover_gallery.hpp"
#include "benchmark/movers/mover_views.hpp"
#include "benchmark/recording_store.hpp"
#include "benchmark/simulated_drive.hpp"
#include "reports/evaluation_json.hpp"
#include "reports/json.hpp"
#include "run/run_summary.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {
namespace {

using Truths = std::map<std::size_t, std::vector<std::uint32_t>>;  // by number of the scan

/// One detector and the figures of its labels.
class RunOfUnit {
 public:
  RunOfUnit(const PaperUnit& unit, const PaperRun& run)
      : unit_(unit),
        run_(run),
        first_(unit.first - std::min(unit.first, run.lead)),
        online_({run.parameters, {}}),
        evaluator_({}) {}

  /// `truths` has the labels of all scans that are not yet evaluated.
  void push(std::size_t scan, const std::shared_ptr<const LidarScan>& measured,
            const std::shared_ptr<const Trajectory>& poses, const Truths& truths,
            const std::function<void()>& step_done) {
    if (scan < first_ || evaluated_ == unit_.count) return;
    DetectorInput input = ablate_motion(measured, poses, run_.compensation);
    for (const LabelledScan& labelled : online_.push(std::move(input.scan), std::move(input.trajectory)))
      evaluate(labelled.detection, truths, step_done);
  }
  void flush(const Truths& truths, const std::function<void()>& step_done) {
    if (evaluated_ == unit_.count) return;
    for (const LabelledScan& labelled : online_.flush()) evaluate(labelled.detection, truths, step_done);
  }
  /// Number of the first scan whose labels are still to come.
  [[nodiscard]] std::size_t next() const { return std::max(unit_.first, next_); }

  [[nodiscard]] Json result() const {
    Json stages = Json::array();
    for (std::size_t s = 0; s < kStageCount; ++s) {
      stages.push_back({{"after", stage_names(run_.parameters.method).at(s)}});
      stages.back().update(to_json(after_stage_.at(s)));
    }
    Json out = {{"method", run_.method},
                {"treatment", run_.treatment},
                {"threshold_m", run_.threshold_m},
                {"final", to_json(final_)},
                {"stages", stages}};
    if (unit_.part == PaperUnit::Part::sweep) return out;
    out["within_range"] = to_json(evaluator_.report())["within_range"];
    out["timing"] = timing_json(seconds_);
    return out;
  }
  [[nodiscard]] const MoverViews& views() const { return views_; }
  [[nodiscard]] const PaperRun& run() const { return run_; }

 private:
  void evaluate(const Detection& detection, const Truths& truths, const std::function<void()>& step_done) {
    const std::size_t scan = first_ + detection.sequence_number;
    next_ = scan + 1;
    if (scan < unit_.first || scan >= unit_.first + unit_.count) return;
    const std::vector<std::uint32_t>& truth = truths.at(scan);
    for (std::size_t s = 0; s < kStageCount; ++s) {
      after_stage_.at(s).add(counts(detection, truth, [&](std::size_t i) {
        return dynamic_after(detection.trace[i], static_cast<Stage>(s));
      }));
    }
    final_.add(counts(detection, truth, [&](std::size_t i) { return detection.dynamic(i); }));
    if (unit_.part == PaperUnit::Part::every_scan) {
      evaluator_.add({scan, truth, labels_of(detection), ranges_of(*detection.scan)});
      seconds_.push_back(detection.seconds);
      if (unit_.pictures) views_.add(scan, detection, truth);
    }
    ++evaluated_;
    step_done();
  }

  template <class Dynamic>
  static Counts counts(const Detection& detection, const std::vector<std::uint32_t>& truth,
                       const Dynamic& dynamic) {
    Counts out;
    for (std::size_t i = 0; i < detection.object.size(); ++i) {
      const MotionTruth motion = motion_of_label(truth[detection.scan->returns[i].input_index]);
      if (motion == MotionTruth::unknown) continue;
      const bool moves = motion == MotionTruth::moving;
      ++(dynamic(i) ? (moves ? out.tp : out.fp) : (moves ? out.fn : out.tn));
    }
    return out;
  }

  const PaperUnit& unit_;
  const PaperRun& run_;
  std::size_t first_;  // scan that the detector is given
  OnlineDetector online_;
  Evaluator evaluator_;
  std::array<PrecisionRecall, kStageCount> after_stage_;
  PrecisionRecall final_;
  std::vector<StageSeconds> seconds_;
  MoverViews views_;
  std::size_t evaluated_ = 0, next_ = 0;
};

std::size_t longest_lead(const PaperUnit& unit) {
  std::size_t lead = 0;
  for (const PaperRun& run : unit.runs) lead = std::max(lead, run.lead);
  return std::min(lead, unit.first);
}

/// Scans after the last one evaluated that a detector waits for.
std::size_t latest_wait(const PaperUnit& unit) {
  int wait = 0;
  for (const PaperRun& run : unit.runs) wait = std::max(wait, run.parameters.forward_gap);
  return static_cast<std::size_t>(wait);
}

/// Number after the last scan that the detectors are given.
std::size_t end_of(const PaperUnit& unit) {
  return std::min(RecordingStore::scans(unit.recording), unit.first + unit.count + latest_wait(unit));
}

SimulatedDrive drive_of(const PaperUnit& unit) {
  const RecordingKey& key = unit.recording;
  return {
      key.scene, {key.seed, key.duration_s, true}, unit.sensor(), {key.range_noise_m, key.faulty, key.seed}};
}

// The scans of a sweep are held, and its many detectors, which hold scans of their own, run one by one.
std::optional<Json> run_sweep(const PaperUnit& unit, const std::function<void()>& step_done) {
  SimulatedDrive drive = drive_of(unit);
  std::map<std::size_t, std::shared_ptr<const LidarScan>> scans;
  Truths truths;
  for (std::size_t k = unit.first - longest_lead(unit); k < end_of(unit); ++k) {
    if (InterruptGuard::requested()) return std::nullopt;
    TrueScan scan = drive.scan(static_cast<int>(k));
    scans[k] = std::move(scan.scan);
    truths[k] = std::move(scan.truth);
  }
  Json results = Json::array();
  for (const PaperRun& run : unit.runs) {
    RunOfUnit detector(unit, run);
    for (const auto& [k, scan] : scans) {
      if (InterruptGuard::requested()) return std::nullopt;
      detector.push(k, scan, drive.trajectory(), truths, step_done);
    }
    detector.flush(truths, step_done);
    results.push_back(detector.result());
  }
  return Json{{"runs", results}, {"pictures", Json::array()}};
}

Json pictures_of(const RunOfUnit& detector, const PaperUnit& unit, const ObjectTruth& objects,
                 const std::filesystem::path& folder) {
  const PaperRun& run = detector.run();
  Json all = draw_gallery(detector.views(), stage_names(run.parameters.method), objects, folder,
                          unit.recording.scene + "." + run.method);
  for (auto& picture : all) picture["method"] = run.method;
  return all;
}

// Few detectors, many scans: every scan goes to all of them and is forgotten.
std::optional<Json> run_every_scan(const PaperUnit& unit, const std::filesystem::path& pictures,
                                   const std::function<void()>& step_done) {
  SimulatedDrive drive = drive_of(unit);
  std::vector<std::unique_ptr<RunOfUnit>> detectors;
  for (const PaperRun& run : unit.runs) detectors.push_back(std::make_unique<RunOfUnit>(unit, run));
  Truths truths;
  for (std::size_t k = unit.first - longest_lead(unit); k < end_of(unit); ++k) {
    if (InterruptGuard::requested()) return std::nullopt;
    TrueScan scan = drive.scan(static_cast<int>(k));
    truths[k] = std::move(scan.truth);
    std::size_t next = k + 1;
    for (const auto& detector : detectors) {
      detector->push(k, scan.scan, drive.trajectory(), truths, step_done);
      next = std::min(next, detector->next());
    }
    truths.erase(truths.begin(), truths.lower_bound(next));
  }
  Json results = Json::array();
  Json drawn = Json::array();
  for (const auto& detector : detectors) {
    detector->flush(truths, step_done);
    results.push_back(detector->result());
    if (!unit.pictures) continue;
    for (const auto& picture : pictures_of(*detector, unit, drive.objects(), pictures))
      drawn.push_back(picture);
  }
  return Json{{"runs", results}, {"pictures", drawn}};
}

}  // namespace

std::size_t steps_of(const PaperUnit& unit) { return unit.count * unit.runs.size(); }

std::optional<Json> run_unit(const PaperUnit& unit, const std::filesystem::path& pictures,
                             const std::function<void()>& step_done) {
  return unit.part == PaperUnit::Part::sweep ? run_sweep(unit, step_done)
                                             : run_every_scan(unit, pictures, step_done);
}

}  // namespace mapless::app
