#include "benchmark/plan.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "reports/digest.hpp"
#include "reports/json.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/core/parameters.hpp>
#include <mapless/io/files.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::app {
namespace {

constexpr std::string_view kMainSensor = "HDL-64E-S2";
constexpr double kMainNoise_m = 0.02;
constexpr std::array<std::string_view, 3> kOtherSensors = {"VLP-16", "Pandar64", "OS1-128"};
constexpr std::array<std::string_view, 3> kOtherSensorScenes = {"town1", "tunnel", "highway"};
constexpr std::array<std::string_view, 2> kTowns = {"town1", "town2"};
constexpr std::array<std::string_view, 3> kAblationScenes = {"town1", "town2", "tunnel"};
constexpr std::array<double, 9> kThresholds_m = {0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0};
constexpr std::array<double, 5> kQuickThresholds_m = {0.05, 0.1, 0.2, 0.4, 0.8};
constexpr double kDuration_s = 20, kQuickDuration_s = 10;
constexpr std::size_t kStretch = 100, kQuickStretch = 30;

template <class Range, class Value>
bool contains(const Range& range, const Value& value) {
  return std::find(range.begin(), range.end(), value) != range.end();
}

RecordingKey key_of(std::string scene, std::string_view sensor, double noise_m) {
  RecordingKey key;
  key.scene = std::move(scene);
  key.sensor = sensor;
  key.range_noise_m = noise_m;
  return key;
}

// The sensor of the key: a named model, or a sensor file, which is named by its stem.
void set_sensor(RecordingKey& key, const std::string& name_or_file) {
  const LidarModel model = model_from_name_or_file(name_or_file);
  if (!std::filesystem::is_regular_file(name_or_file)) {
    key.sensor = model.name;
    return;
  }
  key.sensor = std::filesystem::path(name_or_file).stem().string();
  key.sensor_file = name_or_file;
  Digest digest;
  digest.add_bytes(read_whole_file(name_or_file));
  key.sensor_digest = digest.text();
}

// The scenes that are one place each. `random` is another place with every seed: no row to compare.
std::vector<std::string> fixed_scenes() {
  std::vector<std::string> scenes = scene_names();
  std::erase(scenes, "random");
  return scenes;
}

// Scene, sensor and noise of every row; seed and duration are the same for all.
std::vector<RecordingKey> declared_table() {
  std::vector<RecordingKey> rows;
  for (const std::string& scene : fixed_scenes()) rows.push_back(key_of(scene, kMainSensor, kMainNoise_m));
  for (const std::string_view town : kTowns) {
    for (const double noise_m : {0.0, 0.05}) rows.push_back(key_of(std::string(town), kMainSensor, noise_m));
  }
  for (const std::string_view sensor : kOtherSensors) {
    for (const std::string_view scene : kOtherSensorScenes)
      rows.push_back(key_of(std::string(scene), sensor, kMainNoise_m));
  }
  return rows;
}

void require_noise(double noise_m) {
  if (noise_m >= 0 && noise_m <= 1) return;  // false for NaN
  throw ParameterError({"--noise", "", fmt::format("{}", noise_m), "no standard deviation of ranges",
                        "give metres from 0 to 1"});
}

std::vector<RecordingKey> chosen_table(const PlanOptions& options) {
  const auto scenes = !options.scenes.empty() ? options.scenes
                      : options.quick         ? std::vector<std::string>{"town1"}
                                              : fixed_scenes();
  const auto sensors =
      options.sensors.empty() ? std::vector<std::string>{std::string(kMainSensor)} : options.sensors;
  const auto noises_m =
      options.range_noises_m.empty() ? std::vector<double>{kMainNoise_m} : options.range_noises_m;
  for (const double noise_m : noises_m) require_noise(noise_m);
  std::vector<RecordingKey> rows;
  for (const std::string& sensor : sensors) {
    RecordingKey of_sensor;
    set_sensor(of_sensor, sensor);
    for (const double noise_m : noises_m) {
      for (const std::string& scene : scenes) {
        rows.push_back(of_sensor);
        rows.back().scene = scene;
        rows.back().range_noise_m = noise_m;
      }
    }
  }
  return rows;
}

std::vector<RecordingKey> recordings(const PlanOptions& options) {
  const bool as_declared =
      !options.quick && options.scenes.empty() && options.sensors.empty() && options.range_noises_m.empty();
  const auto rows = as_declared ? declared_table() : chosen_table(options);
  std::vector<RecordingKey> out;
  for (const std::uint64_t seed : options.seeds) {
    for (RecordingKey key : rows) {
      key.seed = seed;
      key.faulty = options.faulty == "on";
      key.duration_s = options.duration_s.value_or(options.quick ? kQuickDuration_s : kDuration_s);
      if (!contains(out, key)) out.push_back(std::move(key));
    }
  }
  return out;
}

// Of the table's first sensor and seed: those of `scenes`, or of the first scene where none of these is
// there.
std::vector<RecordingKey> representative(const std::vector<RecordingKey>& table, const auto& scenes) {
  std::vector<RecordingKey> rows;
  const auto add_where = [&](const auto& condition) {
    for (const RecordingKey& key : table) {
      if (key.sensor == table.front().sensor && key.sensor_digest == table.front().sensor_digest &&
          key.seed == table.front().seed && condition(key))
        rows.push_back(key);
    }
  };
  add_where([&](const RecordingKey& key) { return contains(scenes, key.scene); });
  if (rows.empty()) add_where([&](const RecordingKey& key) { return key.scene == table.front().scene; });
  return rows;
}

struct Setting {
  std::string_view key, value;
};

DetectorParameters with(DetectorParameters parameters, const Setting& setting) {
  assign_parameter(parameter_references(parameters), setting.key, setting.value, "ablation");
  return parameters;
}

std::vector<Job> ablations(const Job& plain) {
  std::vector<Job> jobs;
  const auto add = [&](std::string name, const DetectorParameters& parameters,
                       Compensation compensation = Compensation::full) {
    Job job = plain;
    job.name = std::move(name);
    job.parameters = parameters;
    job.compensation = compensation;
    jobs.push_back(std::move(job));
  };
  const DetectorParameters& p = plain.parameters;
  add("as it is", p);
  add("clouds not compensated", p, Compensation::not_of_clouds);
  add("rays not compensated", p, Compensation::not_of_rays);
  add("neither compensated", p, Compensation::none);
  add("no forward check", with(p, {"forward_gap", "0"}));
  if (p.method == DetectionMethod::voting) {
    add("one earlier scan", with(with(p, {"voting.references", "1"}), {"voting.first_gap", "8"}));
    add("no support filter", with(p, {"voting.seed_score", "0"}));
    add("no growth", with(p, {"voting.grow", "false"}));
  } else {
    add("no box filter", with(p, {"box_filter.score_threshold", "12"}));
    add("no growth", with(p, {"region_growth.max_growth_m", "0"}));
  }
  add("paper profile", detector_profile("paper"));
  return jobs;
}

std::string_view name_of(Part part) {
  return part == Part::table ? "table" : part == Part::sweep ? "sweep" : "ablation";
}

std::string_view name_of(Compensation compensation) {
  switch (compensation) {
    case Compensation::not_of_clouds:
      return "not of clouds";
    case Compensation::not_of_rays:
      return "not of rays";
    case Compensation::none:
      return "none";
    default:
      return "full";
  }
}

}  // namespace

std::string RecordingKey::name() const {
  std::string of_sensor = sensor_digest.empty() ? sensor : sensor + "-" + sensor_digest;
  std::replace_if(
      of_sensor.begin(), of_sensor.end(), [](unsigned char c) { return std::isalnum(c) == 0 && c != '-'; },
      '_');
  return fmt::format("{}_{}_noise{}{}_seed{}_{}s", scene, of_sensor, range_noise_m,
                     faulty ? "" : "_no-faults", seed, duration_s);
}

Json RecordingKey::json() const {
  Json out = {{"scene", scene},           {"sensor", sensor}, {"range_noise_m", range_noise_m},
              {"faulty_returns", faulty}, {"seed", seed},     {"duration_s", duration_s}};
  if (!sensor_digest.empty()) out["sensor_digest"] = sensor_digest;
  return out;
}

LidarModel RecordingKey::model() const {
  return sensor_file.empty() ? named_model(sensor) : model_from_name_or_file(sensor_file);
}

std::string Job::stem() const {
  std::string suffix = name.empty() ? std::string(odometry ? "odometry" : "true poses") : name;
  std::replace(suffix.begin(), suffix.end(), ' ', '_');
  return fmt::format("{}.{}.{}", recording.name(), name_of(part), suffix);
}

Json Job::json() const {
  Json settings = Json::object();
  DetectorParameters copy = parameters;
  for (const ParameterReference& p : parameter_references(copy)) settings[p.key] = p.text();
  return {{"part", name_of(part)},
          {"name", name},
          {"recording", recording.json()},
          {"poses", odometry ? "own odometry" : "true"},
          {"motion_compensation", name_of(compensation)},
          {"first_scans", first_scans ? Json(*first_scans) : Json(nullptr)},
          {"threshold_m", threshold_m ? Json(*threshold_m) : Json(nullptr)},
          {"pictures", pictures},
          {"parameters", settings}};
}

std::size_t stretch_scans(const PlanOptions& options) { return options.quick ? kQuickStretch : kStretch; }

DetectorParameters with_error_threshold(DetectorParameters p, double threshold_m) {
  const double scale = threshold_m / p.comparison.error_threshold_m;
  const auto references = parameter_references(p);
  for (const auto& [key, value] :
       {std::pair("voting.tolerance_m", p.voting.tolerance_m * scale),
        {"voting.tolerance_spacings", p.voting.tolerance_spacings * scale},
        {"comparison.error_threshold_m", threshold_m},
        {"freespace.backward_threshold_m", p.freespace.backward_threshold_m * scale},
        {"freespace.forward_threshold_m", p.freespace.forward_threshold_m * scale}})
    assign_parameter(references, key, fmt::format("{}", value), "sweep");
  return p;
}

std::vector<Job> make_plan(const PlanOptions& options) {
  const DetectorParameters parameters = options.parameters.chosen();
  const auto table = recordings(options);
  std::vector<Job> jobs;
  for (const RecordingKey& key : table) {
    Job job;
    job.recording = key;
    job.parameters = parameters;
    job.pictures = key.sensor == table.front().sensor && key.seed == table.front().seed &&
                   key.range_noise_m == table.front().range_noise_m;
    jobs.push_back(job);
    if (!options.odometry) continue;
    job.odometry = true;
    job.pictures = false;
    jobs.push_back(job);
  }
  for (const RecordingKey& key : representative(table, kTowns)) {
    for (const double threshold_m : options.quick
                                        ? std::vector(kQuickThresholds_m.begin(), kQuickThresholds_m.end())
                                        : std::vector(kThresholds_m.begin(), kThresholds_m.end())) {
      Job job;
      job.part = Part::sweep;
      job.recording = key;
      job.name = fmt::format("{} m", threshold_m);
      job.parameters = with_error_threshold(parameters, threshold_m);
      job.first_scans = stretch_scans(options);
      job.threshold_m = threshold_m;
      jobs.push_back(std::move(job));
    }
  }
  for (const RecordingKey& key : representative(table, kAblationScenes)) {
    if (key.range_noise_m != table.front().range_noise_m) continue;
    Job plain;
    plain.part = Part::ablation;
    plain.recording = key;
    plain.parameters = parameters;
    plain.first_scans = stretch_scans(options);
    for (Job& job : ablations(plain)) jobs.push_back(std::move(job));
  }
  return jobs;
}

}  // namespace mapless::app
