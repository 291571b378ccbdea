#include "benchmark/job_run.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "benchmark/ablated_motion.hpp"
#include "benchmark/middle_view.hpp"
#include "benchmark/movers/mover_gallery.hpp"
#include "benchmark/movers/mover_views.hpp"
#include "pictures/scan_picture.hpp"
#include "reports/evaluation_json.hpp"
#include "reports/json.hpp"
#include "run/run_summary.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::app {
namespace {

class JobRun {
 public:
  JobRun(const Job& job, const Dataset& dataset, const ObjectTruth& objects,
         const std::function<void()>& scan_done)
      : job_(job),
        dataset_(dataset),
        poses_(job.odometry ? nullptr : dataset.trajectory()),
        online_({job.parameters, {}}),
        evaluator_(objects),
        delays_(objects),
        scan_done_(scan_done),
        middle_(dataset.size()) {}

  /// False where interrupted.
  bool run() {
    const std::size_t count = std::min(dataset_.size(), job_.first_scans.value_or(dataset_.size()));
    for (std::size_t k = 0; k < count; ++k) {
      if (InterruptGuard::requested()) return false;
      finish(push(std::make_shared<const LidarScan>(dataset_.read(k))));
    }
    finish(online_.flush());
    return !InterruptGuard::requested();
  }

  [[nodiscard]] Json result() const {
    Json stages = Json::array();
    for (std::size_t s = 0; s < kStageCount; ++s) {
      stages.push_back({{"after", stage_names(job_.parameters.method).at(s)}});
      stages.back().update(to_json(after_stage_.at(s)));
    }
    const EvaluationReport report = evaluator_.report();
    Json out = {{"scans", report.points.scans()},
                {"final", to_json(report.points)},
                {"stages", stages},
                {"timing", timing_json(seconds_)},
                {"threads", tbb::this_task_arena::max_concurrency()},
                {"odometry_trouble", online_.odometry_report().trouble()}};
    if (job_.part != Part::table) return out;
    out["measures"] = to_json(report);
    out["measures"]["sight"] = to_json(sight_.report());
    const auto delays = delays_.report();
    out["measures"]["delays"] = delays ? to_json(*delays) : Json(nullptr);
    return out;
  }
  [[nodiscard]] const MoverViews& views() const { return views_; }
  [[nodiscard]] const MiddleView& middle() const { return middle_; }
  /// The scan in the middle of the recording.
  [[nodiscard]] const std::optional<Canvas>& scan_picture() const { return scan_picture_; }

 private:
  std::vector<LabelledScan> push(std::shared_ptr<const LidarScan> scan) {
    if (!poses_) return online_.push(std::move(scan));
    DetectorInput input = ablate_motion(std::move(scan), poses_, job_.compensation);
    return online_.push(std::move(input.scan), std::move(input.trajectory));
  }

  void finish(const std::vector<LabelledScan>& scans) {
    for (const LabelledScan& labelled : scans) evaluate(labelled.detection);
  }

  void evaluate(const Detection& detection) {
    const std::size_t k = detection.sequence_number;
    const auto truth = dataset_.read_labels(k).value();
    for (std::size_t s = 0; s < kStageCount; ++s) {
      after_stage_.at(s).add(counts(detection, truth, [&](std::size_t i) {
        return dynamic_after(detection.trace[i], static_cast<Stage>(s));
      }));
    }
    const auto labels = labels_of(detection);
    const auto ranges_m = ranges_of(*detection.scan);
    const ScanLabels compared = {k, truth, labels, ranges_m};
    evaluator_.add(compared);
    if (job_.part == Part::table) {
      sight_.add(*detection.scan, compared);
      delays_.add(compared);
    }
    seconds_.push_back(detection.seconds);
    if (job_.pictures) look_at(detection, labels, truth);
    scan_done_();
  }

  void look_at(const Detection& detection, const std::vector<std::uint32_t>& labels,
               const std::vector<std::uint32_t>& truth) {
    const std::size_t k = detection.sequence_number;
    views_.add(k, detection, truth);
    middle_.add(detection);
    if (k != dataset_.size() / 2) return;
    PictureOptions how;
    how.extent_m = 40;
    how.title =
        fmt::format("{}, {}, scan {} of {}", job_.recording.scene, job_.recording.sensor, k, dataset_.size());
    scan_picture_ = draw_scan(*detection.scan, labels, truth, how);
  }

  template <class Dynamic>
  static Counts counts(const Detection& detection, const std::vector<std::uint32_t>& truth,
                       const Dynamic& dynamic) {
    std::vector<std::uint8_t> predicted(truth.size(), 0);
    for (std::size_t i = 0; i < detection.object.size(); ++i)
      predicted[detection.scan->returns[i].input_index] = dynamic(i) ? 1 : 0;
    return count_points(truth, predicted);
  }

  const Job& job_;
  const Dataset& dataset_;
  std::shared_ptr<const Trajectory> poses_;  // null: own odometry
  OnlineDetector online_;
  Evaluator evaluator_;
  SightEvaluator sight_;
  DelayEvaluator delays_;
  const std::function<void()>& scan_done_;
  std::array<PrecisionRecall, kStageCount> after_stage_;
  std::vector<StageSeconds> seconds_;
  MoverViews views_;
  MiddleView middle_;
  std::optional<Canvas> scan_picture_;
};

}  // namespace

std::optional<Json> run_job(const Job& job, const std::filesystem::path& recording,
                            const BenchmarkFolder& folder, const std::function<void()>& scan_done) {
  const auto dataset = open_dataset(recording);
  const ObjectTruth objects = read_object_truth(recording);
  JobRun run(job, *dataset, objects, scan_done);
  if (!run.run()) return std::nullopt;
  Json result = run.result();
  if (!job.pictures) return std::make_optional(std::move(result));
  const std::string name = job.recording.name();
  result["view"] = name + ".html";
  run.middle().write(*dataset, name, folder.views() / (name + ".html"));
  result["pictures"] =
      draw_gallery(run.views(), stage_names(job.parameters.method), objects, folder.pictures(), name);
  if (run.scan_picture()) {
    const std::string file = name + ".scan.png";
    run.scan_picture()->write_png(folder.pictures() / file);
    result["pictures"].push_back({{"file", file},
                                  {"kind", "scan"},
                                  {"caption",
                                   "The scan in the middle of the recording, as the sensor sees it and "
                                   "from above: moving points found green, missed blue, static ones "
                                   "called dynamic orange"}});
  }
  return std::make_optional(std::move(result));
}

}  // namespace mapless::app
