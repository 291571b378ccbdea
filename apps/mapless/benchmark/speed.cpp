#include "benchmark/speed.hpp"

#include <array>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "benchmark/milliseconds.hpp"
#include "benchmark/speed_drive.hpp"
#include "benchmark/speed_pipeline.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/detection/object_tracker.hpp>
#include <mapless/evaluation/quantile.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFirstScan = 33;  // the default detector asks scans up to 32 before, and one after
constexpr int kYardstickEvery = 5;

struct Times {
  std::vector<StageSeconds> stages;
  std::vector<double> detection_ms, objects_ms, yardstick_ms;
};

/// Everything measured of one sensor, scan by scan and side by side, so that what else the machine does meets
/// all of it.
class SensorRun {
 public:
  SensorRun(const SpeedOptions& options, const std::string& sensor)
      : drive_(options.scene, options.duration_s, options.seed, sensor),
        scans_(static_cast<int>(options.duration_s * drive_.rotation_rate_hz())),
        detector_(options.detector) {
    if (scans_ < kFirstScan + 2 * kYardstickEvery) {
      throw ParameterError({"--duration-s", "", fmt::format("{}", options.duration_s),
                            "is too short to measure", "ask for 5 seconds or more"});
    }
    const auto add = [&](int threads, bool side_by_side) {
      pipelines_.push_back(
          std::make_unique<SpeedPipeline>(threads, side_by_side, options.detector, options.odometry));
    };
    add(1, false);
    add(2, true);
    for (int threads = 2; threads <= options.most_threads; ++threads) add(threads, false);
    for (int threads = 3; threads <= options.most_threads; ++threads) add(threads, true);
  }

  void run() {
    Progress progress("scans");
    for (int k = 0; k < scans_ && !InterruptGuard::requested(); ++k) {
      const auto scan = drive_.scan(k);
      one_thread_.execute([&] { measure_detection(scan, k); });
      for (const auto& pipeline : pipelines_) pipeline->add(scan, k >= kFirstScan);
      progress.update(static_cast<std::size_t>(k + 1), static_cast<std::size_t>(scans_));
    }
  }

  [[nodiscard]] std::size_t rays() const { return drive_.rays(); }
  [[nodiscard]] const Times& times() const { return times_; }
  /// One after the other on one thread, side by side on two, and the others.
  [[nodiscard]] const std::vector<std::unique_ptr<SpeedPipeline>>& pipelines() const { return pipelines_; }

 private:
  void measure_detection(const std::shared_ptr<const LidarScan>& scan, int k) {
    std::optional<Detection> found;
    const double detection_ms =
        milliseconds_of([&] { found = detector_.process(scan, drive_.trajectory()); });
    if (!found) return;
    const double objects_ms = milliseconds_of([&] { tracker_.process(*found, drive_.trajectory()); });
    if (k < kFirstScan) return;
    times_.stages.push_back(found->seconds);
    times_.detection_ms.push_back(detection_ms);
    times_.objects_ms.push_back(objects_ms);
    if (k % kYardstickEvery == 0) take_yardstick(scan);
  }

  void take_yardstick(const std::shared_ptr<const LidarScan>& scan) {
    auto points = compensate(scan, drive_.trajectory()).points_0;
    if (!before_.empty()) times_.yardstick_ms.push_back(yardstick_ms(before_, points));
    before_ = std::move(points);
  }

  SpeedDrive drive_;
  int scans_;
  Detector detector_;
  ObjectTracker tracker_;
  std::vector<std::unique_ptr<SpeedPipeline>> pipelines_;
  tbb::task_arena one_thread_{1};
  std::vector<Eigen::Vector3d> before_;  // points of the scan the last yardstick was taken at
  Times times_;
};

Json row(const std::string& name, const std::vector<double>& ms, std::size_t rays, double detection,
         double yardstick) {
  const auto of = [&](double q) { return quantile(ms, q).value_or(0); };
  return {{"name", name},
          {"median_ms", of(0.5)},
          {"p95_ms", of(0.95)},
          {"p99_ms", of(0.99)},
          {"ns_per_ray", of(0.5) * 1e6 / static_cast<double>(rays)},
          {"share_of_detection", of(0.5) / detection},
          {"yardsticks", of(0.5) / yardstick}};
}

Json rows(const SensorRun& run) {
  const Times& times = run.times();
  const double detection = quantile(times.detection_ms, 0.5).value_or(0);
  const double yardstick = quantile(times.yardstick_ms, 0.5).value_or(0);
  Json all = Json::array();
  const auto add = [&](const char* name, const std::vector<double>& ms) {
    all.push_back(row(name, ms, run.rays(), detection, yardstick));
  };
  using Stage = std::pair<const char*, double StageSeconds::*>;
  constexpr std::array kStages = {Stage{"compensation", &StageSeconds::compensation},
                                  Stage{"neighbours", &StageSeconds::neighbours},
                                  Stage{"normals", &StageSeconds::normals},
                                  Stage{"comparison", &StageSeconds::comparison},
                                  Stage{"backward", &StageSeconds::backward},
                                  Stage{"forward", &StageSeconds::forward},
                                  Stage{"box filter", &StageSeconds::box_filter},
                                  Stage{"region growth", &StageSeconds::region_growth}};
  for (const auto& [name, stage] : kStages) {
    std::vector<double> ms;
    for (const StageSeconds& s : times.stages) ms.push_back(1e3 * s.*stage);
    if (quantile(ms, 1).value_or(0) > 0) add(name, ms);  // the method has the stage
  }
  add("detection", times.detection_ms);
  add("odometry", run.pipelines()[0]->odometry_ms());
  add("pipeline", run.pipelines()[0]->milliseconds());
  add("on two threads", run.pipelines()[1]->milliseconds());
  add("objects", times.objects_ms);
  add("yardstick", times.yardstick_ms);
  return all;
}

Json threads_json(const SensorRun& run) {
  Json all = Json::array();
  for (const auto& pipeline : run.pipelines()) {
    all.push_back({{"threads", pipeline->threads()},
                   {"side_by_side", pipeline->side_by_side()},
                   {"median_ms", quantile(pipeline->milliseconds(), 0.5).value_or(0)}});
  }
  return all;
}

}  // namespace

Json measure_speed(const SpeedOptions& options) {
  Json sensors = Json::array();
  for (const std::string& sensor : options.sensors) {
    SensorRun run(options, sensor);
    run.run();
    sensors.push_back({{"sensor", sensor},
                       {"scans", run.times().detection_ms.size()},
                       {"rays", run.rays()},
                       {"rows", rows(run)},
                       {"threads", threads_json(run)}});
  }
  return {{"scene", options.scene}, {"sensors", sensors}};
}

std::string speed_text(const Json& speed) {
  std::string text;
  for (const Json& sensor : speed["sensors"]) {
    text += fmt::format("{} in {}, {} rays, {} scans, one thread each but where said\n",
                        sensor["sensor"].get<std::string>(), speed["scene"].get<std::string>(),
                        sensor["rays"].get<std::size_t>(), sensor["scans"].get<std::size_t>());
    text += fmt::format("{:<15}{:>10}{:>9}{:>9}{:>9}{:>8}{:>12}\n", "", "median ms", "p95", "p99", "ns/ray",
                        "share", "yardsticks");
    for (const Json& r : sensor["rows"]) {
      const auto number = [&](const char* name) { return r[name].get<double>(); };
      text +=
          fmt::format("{:<15}{:>10.2f}{:>9.2f}{:>9.2f}{:>9.1f}{:>7.0f}%{:>12.3f}\n",
                      r["name"].get<std::string>(), number("median_ms"), number("p95_ms"), number("p99_ms"),
                      number("ns_per_ray"), 100 * number("share_of_detection"), number("yardsticks"));
    }
  }
  return text;
}

}  // namespace mapless::app
