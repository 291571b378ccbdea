#include "benchmark/speed/speed.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "benchmark/simulated_drive.hpp"
#include "benchmark/speed/speed_pipeline.hpp"
#include "benchmark/speed/speed_sensor.hpp"
#include "benchmark/speed/yardstick.hpp"
#include "reports/json.hpp"
#include "run/busy_time.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless::app {
namespace {

constexpr int kFirstScan = 33;  // the reference scans of the default detector: up to 32 before, and one after
constexpr int kYardstickEvery = 5;  // scans; it takes longer than the detection

constexpr double kRangeNoise_m = SensorOptions().range_noise_m;

struct Times {
  std::vector<StageSeconds> stages;
  std::vector<BusyTime> detection, odometry, yardstick;
};

/// All measurements of one sensor, interleaved scan by scan, so that other load on the computer affects all
/// of them alike.
class SensorRun {
 public:
  SensorRun(const SpeedOptions& options, const std::string& sensor)
      : drive_(options.scene, {options.seed, options.duration_s, true}, speed_sensor(sensor),
               {kRangeNoise_m, true, options.seed}),
        scans_(static_cast<int>(options.duration_s * drive_.model().rotation_rate_hz)),
        detector_(options.detector),
        odometry_(options.odometry) {
    if (scans_ < kFirstScan + 2 * kYardstickEvery) {
      throw ParameterError({"--duration-s", "", fmt::format("{}", options.duration_s),
                            "is too short to measure", "give 5 seconds or more"});
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
      const auto scan = drive_.scan(k).scan;
      one_thread_.execute([&] { measure_steps(scan, k); });
      for (const auto& pipeline : pipelines_) pipeline->add(scan, k >= kFirstScan);
      progress.update(static_cast<std::size_t>(k + 1), static_cast<std::size_t>(scans_));
    }
  }

  [[nodiscard]] std::size_t rays() const {
    return drive_.model().lasers.size() * static_cast<std::size_t>(drive_.model().columns);
  }
  [[nodiscard]] const Times& times() const { return times_; }
  /// One after the other on one thread, side by side on two, and the others.
  [[nodiscard]] const std::vector<std::unique_ptr<SpeedPipeline>>& pipelines() const { return pipelines_; }

 private:
  // Detection along the true trajectory, and odometry, each by itself.
  void measure_steps(const std::shared_ptr<const LidarScan>& scan, int k) {
    std::vector<Detection> found;
    const BusyTime detection = busy_time_of([&] { found = detector_.process(scan, *drive_.trajectory()); });
    const BusyTime odometry = busy_time_of([&] { odometry_.process(scan); });
    if (k < kFirstScan) return;
    times_.odometry.push_back(odometry);
    for (const Detection& detected : found) times_.stages.push_back(detected.seconds);
    times_.detection.push_back(detection);
    if (k % kYardstickEvery == 0) take_yardstick(scan);
  }

  void take_yardstick(const std::shared_ptr<const LidarScan>& scan) {
    auto points = compensate(scan, *drive_.trajectory()).points_0;
    if (!before_.empty()) times_.yardstick.push_back(yardstick(before_, points));
    before_ = std::move(points);
  }

  SimulatedDrive drive_;
  int scans_;
  Detector detector_;
  LidarOdometry odometry_;
  std::vector<std::unique_ptr<SpeedPipeline>> pipelines_;
  tbb::task_arena one_thread_{1};
  std::vector<Eigen::Vector3d> before_;  // points of the scan the last yardstick was taken at
  Times times_;
};

std::vector<double> wall_ms(const std::vector<BusyTime>& times) {
  std::vector<double> ms(times.size());
  std::transform(times.begin(), times.end(), ms.begin(), [](const BusyTime& t) { return t.wall_ms(); });
  return ms;
}

double median_processor_ms(const std::vector<BusyTime>& times) {
  std::vector<double> ms(times.size());
  std::transform(times.begin(), times.end(), ms.begin(), [](const BusyTime& t) { return t.processor_ms(); });
  return quantile(ms, 0.5).value_or(0);
}

/// Rows beside those of detection and the yardstick.
class RowMaker {
 public:
  explicit RowMaker(const SensorRun& run)
      : rays_(static_cast<double>(run.rays())),
        detection_ms_(quantile(wall_ms(run.times().detection), 0.5).value_or(0)),
        yardstick_ms_(quantile(wall_ms(run.times().yardstick), 0.5).value_or(0)),
        yardstick_processor_ms_(median_processor_ms(run.times().yardstick)) {}

  /// Of a stage, of which there is the wall time alone.
  [[nodiscard]] Json of_stage(const std::string& name, const std::vector<double>& ms) const {
    const auto of = [&](double q) { return quantile(ms, q).value_or(0); };
    return {{"name", name},
            {"median_ms", of(0.5)},
            {"p95_ms", of(0.95)},
            {"p99_ms", of(0.99)},
            {"ns_per_ray", of(0.5) * 1e6 / rays_},
            {"share_of_detection", of(0.5) / detection_ms_},
            {"processor_ms", nullptr},
            {"yardsticks", of(0.5) / yardstick_ms_}};
  }
  [[nodiscard]] Json of(const std::string& name, const std::vector<BusyTime>& times) const {
    Json row = of_stage(name, wall_ms(times));
    const double processor_ms = median_processor_ms(times);
    row["processor_ms"] = processor_ms;
    row["yardsticks"] = processor_ms / yardstick_processor_ms_;
    return row;
  }

 private:
  double rays_, detection_ms_, yardstick_ms_, yardstick_processor_ms_;
};

Json rows(const SensorRun& run) {
  const Times& times = run.times();
  const RowMaker make(run);
  Json all = Json::array();
  using Stage = std::pair<const char*, double StageSeconds::*>;
  constexpr std::array kStages = {Stage{"compensation", &StageSeconds::compensation},
                                  Stage{"neighbours", &StageSeconds::neighbours},
                                  Stage{"normals", &StageSeconds::normals},
                                  Stage{"comparison", &StageSeconds::comparison},
                                  Stage{"backward", &StageSeconds::backward},
                                  Stage{"forward", &StageSeconds::forward},
                                  Stage{"evidence", &StageSeconds::evidence},
                                  Stage{"filter", &StageSeconds::filter},
                                  Stage{"region growth", &StageSeconds::region_growth},
                                  Stage{"tracking", &StageSeconds::tracking}};
  for (const auto& [name, stage] : kStages) {
    std::vector<double> ms;
    for (const StageSeconds& s : times.stages) ms.push_back(1e3 * s.*stage);
    if (quantile(ms, 1).value_or(0) > 0) all.push_back(make.of_stage(name, ms));  // the method has the stage
  }
  all.push_back(make.of("detection", times.detection));
  all.push_back(make.of("odometry", times.odometry));
  all.push_back(make.of("pipeline", run.pipelines()[0]->times()));
  all.push_back(make.of("on two threads", run.pipelines()[1]->times()));
  all.push_back(make.of("yardstick", times.yardstick));
  return all;
}

Json threads_json(const SensorRun& run) {
  Json all = Json::array();
  for (const auto& pipeline : run.pipelines()) {
    all.push_back({{"threads", pipeline->threads()},
                   {"side_by_side", pipeline->side_by_side()},
                   {"median_ms", quantile(wall_ms(pipeline->times()), 0.5).value_or(0)}});
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
                       {"scans", run.times().detection.size()},
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
    text += fmt::format("{:<15}{:>10}{:>9}{:>9}{:>9}{:>8}{:>13}{:>12}\n", "", "median ms", "p95", "p99",
                        "ns/ray", "share", "processor ms", "yardsticks");
    for (const Json& r : sensor["rows"]) {
      const auto number = [&](const char* name) { return r[name].get<double>(); };
      const Json& processor_ms = r["processor_ms"];
      text += fmt::format("{:<15}{:>10.2f}{:>9.2f}{:>9.2f}{:>9.1f}{:>7.0f}%{:>13}{:>12.3f}\n",
                          r["name"].get<std::string>(), number("median_ms"), number("p95_ms"),
                          number("p99_ms"), number("ns_per_ray"), 100 * number("share_of_detection"),
                          processor_ms.is_null() ? "" : fmt::format("{:.2f}", processor_ms.get<double>()),
                          number("yardsticks"));
    }
  }
  return text;
}

}  // namespace mapless::app
