#include "benchmark/job_run.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "benchmark/mover_album.hpp"
#include "benchmark/mover_views.hpp"
#include "benchmark/untold_motion.hpp"
#include "interrupt.hpp"
#include "motion_source.hpp"
#include "run_summary.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::app {
namespace {

using Json = nlohmann::ordered_json;

Json rate(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

MotionSource motion_of(const Job& job, const Dataset& dataset) {
  return job.odometry ? MotionSource::odometry() : MotionSource(dataset, {}, 0);
}

class JobRun {
 public:
  JobRun(const Job& job, const Dataset& dataset, const std::function<void()>& scan_done)
      : job_(job),
        dataset_(dataset),
        motion_(motion_of(job, dataset)),
        detector_(job.parameters),
        scan_done_(scan_done) {}

  /// False where interrupted.
  bool run() {
    const std::size_t count = std::min(dataset_.size(), job_.first_scans.value_or(dataset_.size()));
    for (std::size_t k = 0; k < count; ++k) {
      if (!detect(motion_.add(std::make_shared<const LidarScan>(dataset_.read(k))))) return false;
    }
    if (!detect(motion_.flush())) return false;
    while (const auto detection = detector_.flush()) {
      if (InterruptGuard::requested()) return false;
      finish_scan(*detection);
    }
    return true;
  }

  [[nodiscard]] Json result() const {
    Json stages = Json::array();
    for (std::size_t s = 0; s < kStageCount; ++s) {
      stages.push_back({{"after", kStageNames.at(s)}});
      stages.back().update(rates_json(after_stage_.at(s)));
    }
    return {{"scans", final_.scans()},
            {"final", rates_json(final_)},
            {"stages", stages},
            {"timing", timing_json(seconds_)},
            {"odometry_trouble", motion_.trouble()}};
  }
  [[nodiscard]] const MoverViews& views() const { return views_; }

 private:
  bool detect(const std::vector<std::shared_ptr<const LidarScan>>& scans) {
    for (const auto& scan : scans) {
      if (InterruptGuard::requested()) return false;
      const DetectorInput input = withhold_motion(scan, motion_.trajectory(), job_.compensation);
      if (const auto detection = detector_.process(input.scan, *input.trajectory)) finish_scan(*detection);
    }
    return true;
  }

  void finish_scan(const Detection& detection) {
    const std::size_t k = detection.sequence_number;
    const auto truth = dataset_.read_labels(k).value();
    for (std::size_t s = 0; s < kStageCount; ++s) {
      after_stage_.at(s).add(judged(detection, truth, [&](std::size_t i) {
        return dynamic_after(detection.trace[i], static_cast<Stage>(s));
      }));
    }
    final_.add(judged(detection, truth, [&](std::size_t i) { return detection.dynamic(i); }));
    seconds_.push_back(detection.seconds);
    if (job_.pictures) views_.add(k, detection, truth);
    scan_done_();
  }

  template <class Dynamic>
  static Counts judged(const Detection& detection, const std::vector<std::uint32_t>& truth,
                       const Dynamic& dynamic) {
    std::vector<std::uint8_t> predicted(truth.size(), 0);
    for (std::size_t i = 0; i < detection.object.size(); ++i)
      predicted[detection.scan->returns[i].input_index] = dynamic(i) ? 1 : 0;
    return count_points(truth, predicted);
  }

  const Job& job_;
  const Dataset& dataset_;
  MotionSource motion_;
  Detector detector_;
  const std::function<void()>& scan_done_;
  std::array<PrecisionRecall, kStageCount> after_stage_;
  PrecisionRecall final_;
  std::vector<StageSeconds> seconds_;
  MoverViews views_;
};

}  // namespace

Json rates_json(const PrecisionRecall& r) {
  const Counts& c = r.total();
  return {{"scans", r.scans()},
          {"tp", c.tp},
          {"fp", c.fp},
          {"fn", c.fn},
          {"tn", c.tn},
          {"precision", rate(c.precision())},
          {"recall", rate(c.recall())},
          {"f1", rate(c.f1())},
          {"iou", rate(c.iou())},
          {"average_precision", rate(r.average_precision())},
          {"n_p", r.precision_scans()},
          {"average_recall", rate(r.average_recall())},
          {"n_r", r.recall_scans()}};
}

std::optional<Json> run_job(const Job& job, const std::filesystem::path& recording,
                            const std::filesystem::path& pictures, const std::function<void()>& scan_done) {
  const auto dataset = open_dataset(recording);
  JobRun run(job, *dataset, scan_done);
  if (!run.run()) return std::nullopt;
  Json result = run.result();
  if (job.pictures) result["pictures"] = draw_album(run.views(), recording, pictures, job.recording.name());
  return result;
}

}  // namespace mapless::app
