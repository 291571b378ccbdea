#include "benchmark/speed.hpp"

#include <array>
#include <chrono>
#include <memory>
#include <nanoflann.hpp>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "interrupt.hpp"
#include "progress.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/evaluation/quantile.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>

namespace mapless::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFirstScan = 33;  // the default detector asks scans up to 32 before, and one after
constexpr int kYardstickEvery = 5;

/// Runs `step` and tells how long it took [ms].
template <class Step>
double milliseconds_of(Step&& step) {
  const auto start = std::chrono::steady_clock::now();
  step();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

struct CloudAdaptor {
  const std::vector<Eigen::Vector3d>& points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t d) const {
    return points[i][static_cast<Eigen::Index>(d)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

double yardstick_ms(const std::vector<Eigen::Vector3d>& of, const std::vector<Eigen::Vector3d>& asked) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, CloudAdaptor>,
                                                   CloudAdaptor, 3>;
  return milliseconds_of([&] {
    const CloudAdaptor cloud{of};
    Tree tree(3, cloud);
    tree.buildIndex();
    for (const Eigen::Vector3d& q : asked) {
      unsigned index = 0;
      double distance2 = 0;
      tree.knnSearch(q.data(), 1, &index, &distance2);
    }
  });
}

/// A scene with a sensor in it whose scans never touch the disk.
class Drive {
 public:
  Drive(const SpeedOptions& options, const std::string& sensor)
      : scene_(make_scene(options.scene, {options.seed, options.duration_s, true})),
        model_(std::make_shared<const LidarModel>(named_model(sensor))),
        trajectory_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), "scene")),
        world_(scene_.world),
        sensor_(model_, trajectory_, world_, {0.02, true, options.seed}) {}

  [[nodiscard]] std::shared_ptr<const LidarScan> scan(int number) {
    const SimulatedScan cast = sensor_.scan(number);
    LidarScan scan;
    scan.model = model_;
    scan.start = cast.start;
    scan.column_period = Duration::from_seconds(1 / model_->rotation_rate_hz / model_->columns);
    scan.columns = model_->columns;
    return std::make_shared<const LidarScan>(organise(std::move(scan), cast.records, "simulated scan"));
  }
  [[nodiscard]] const Trajectory& trajectory() const { return *trajectory_; }
  [[nodiscard]] double rotation_rate_hz() const { return model_->rotation_rate_hz; }

 private:
  Scene scene_;
  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld world_;
  SimulatedSensor sensor_;
};

struct Times {
  std::vector<StageSeconds> stages;
  std::vector<double> detection_ms, odometry_ms, yardstick_ms;
};

Times run(Drive& drive, int scans, const SpeedOptions& options, std::size_t& rays) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  Detector detector(options.detector);
  LidarOdometry odometry(options.odometry);
  Progress progress("scans");
  std::vector<Eigen::Vector3d> before;
  Times times;
  for (int k = 0; k < scans && !InterruptGuard::requested(); ++k) {
    const auto scan = drive.scan(k);
    rays = scan->cells.size();
    std::optional<Detection> detection;
    const double detection_ms =
        milliseconds_of([&] { detection = detector.process(scan, drive.trajectory()); });
    const double odometry_ms = milliseconds_of([&] { odometry.process(scan); });
    progress.update(static_cast<std::size_t>(k + 1), static_cast<std::size_t>(scans));
    if (k < kFirstScan || !detection) continue;
    times.stages.push_back(detection->seconds);
    times.detection_ms.push_back(detection_ms);
    times.odometry_ms.push_back(odometry_ms);
    if (k % kYardstickEvery != 0) continue;
    auto points = compensate(scan, drive.trajectory()).points_0;
    if (!before.empty()) times.yardstick_ms.push_back(yardstick_ms(before, points));
    before = std::move(points);
  }
  progress.clear();
  return times;
}

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

Json rows(const Times& times, std::size_t rays) {
  const double detection = quantile(times.detection_ms, 0.5).value_or(0);
  const double yardstick = quantile(times.yardstick_ms, 0.5).value_or(0);
  Json all = Json::array();
  const auto add = [&](const char* name, const std::vector<double>& ms) {
    all.push_back(row(name, ms, rays, detection, yardstick));
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
  add("odometry", times.odometry_ms);
  add("yardstick", times.yardstick_ms);
  return all;
}

}  // namespace

Json measure_speed(const SpeedOptions& options) {
  Json sensors = Json::array();
  for (const std::string& sensor : options.sensors) {
    Drive drive(options, sensor);
    const int scans = static_cast<int>(options.duration_s * drive.rotation_rate_hz());
    if (scans < kFirstScan + 2 * kYardstickEvery) {
      throw ParameterError({"--duration-s", "", fmt::format("{}", options.duration_s),
                            "is too short to measure", "ask for 5 seconds or more"});
    }
    std::size_t rays = 0;
    const Times times = run(drive, scans, options, rays);
    sensors.push_back({{"sensor", sensor},
                       {"scans", times.detection_ms.size()},
                       {"rays", rays},
                       {"rows", rows(times, rays)}});
  }
  return {{"scene", options.scene}, {"threads", 1}, {"sensors", sensors}};
}

std::string speed_text(const Json& speed) {
  std::string text;
  for (const Json& sensor : speed["sensors"]) {
    text += fmt::format("{} in {}, {} rays, {} scans, one thread\n", sensor["sensor"].get<std::string>(),
                        speed["scene"].get<std::string>(), sensor["rays"].get<std::size_t>(),
                        sensor["scans"].get<std::size_t>());
    text += fmt::format("{:<14}{:>10}{:>9}{:>9}{:>9}{:>8}{:>12}\n", "", "median ms", "p95", "p99", "ns/ray",
                        "share", "yardsticks");
    for (const Json& r : sensor["rows"]) {
      const auto number = [&](const char* name) { return r[name].get<double>(); };
      text +=
          fmt::format("{:<14}{:>10.2f}{:>9.2f}{:>9.2f}{:>9.1f}{:>7.0f}%{:>12.3f}\n",
                      r["name"].get<std::string>(), number("median_ms"), number("p95_ms"), number("p99_ms"),
                      number("ns_per_ray"), 100 * number("share_of_detection"), number("yardsticks"));
    }
  }
  return text;
}

}  // namespace mapless::app
