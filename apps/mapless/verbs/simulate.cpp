#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "options/option_checks.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/core/time.hpp>
#include <mapless/io/files.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::app {
namespace {

struct SimulateOptions {
  std::string scene;
  std::string output;
  std::string rig;  // file; empty: one sensor
  std::string sensor = "HDL-64E-S2";
  std::string format = "native";
  std::string faulty = "on";
  std::string world = "arbitrary";
  SceneOptions making;
  SensorOptions sensing;
  std::optional<std::size_t> threads;
};

// Added to the seed of the noise of each sensor of a rig but the first: one seed has one noise.
constexpr std::uint64_t kSeedsApart = 1000;

void require_new(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder)) {
    throw OutputError({folder.string(), "", "", "exists already", "choose a new folder, or remove it"});
  }
}

/// Reserves disk space for the files that are written last, so that a full disk leaves a valid recording.
class RoomForTheEnd {
 public:
  RoomForTheEnd(std::filesystem::path file, std::size_t bytes) : file_(std::move(file)) {
    write_file_atomically(file_, std::string(bytes, ' '));
  }
  ~RoomForTheEnd() { release(); }
  RoomForTheEnd(const RoomForTheEnd&) = delete;
  RoomForTheEnd& operator=(const RoomForTheEnd&) = delete;
  void release() const {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }

 private:
  std::filesystem::path file_;
};

// Upper bound of trajectory, times and poses: a row of any of them has less than 200 characters.
std::size_t bytes_at_the_end(const Scene& scene, int scans) {
  return 65536 + 200 * scene.poses.size() + 300 * static_cast<std::size_t>(scans);
}

/// Returns the number of scans written, less than `count` where interrupted; a valid recording either way.
int write_scans(SimulatedSensor& sensor, SequenceWriter& writer, const RoomForTheEnd& room, int count) {
  Progress progress("scans");
  int done = 0;
  try {
    for (; done < count && !InterruptGuard::requested(); ++done) {
      writer.add(sensor.scan(done));
      progress.update(static_cast<std::size_t>(done) + 1, static_cast<std::size_t>(count));
    }
  } catch (const Error&) {
    progress.clear();
    room.release();
    try {
      writer.finish();
    } catch (const OutputError&) {  // the first error is the one to report
    }
    throw;
  }
  progress.clear();
  room.release();
  writer.finish();
  return done;
}

// Scans of this sensor within the duration. Throws ParameterError where there is none.
int scans_within(const SimulateOptions& options, const LidarModel& model) {
  const double turns = std::floor(options.making.duration_s * model.rotation_rate_hz + 1e-6);
  const int count = static_cast<int>(std::min(turns, 1e9));
  if (count >= 1) return count;
  throw ParameterError({"--duration-s", "", fmt::format("{}", options.making.duration_s),
                        "shorter than one scan",
                        fmt::format("give at least {}", 1 / model.rotation_rate_hz)});
}

// The scene as one sensor of a rig sees it; the vehicle's frame is that of the scene's own sensor.
Scene seen_by(Scene scene, const RigSensor& sensor) {
  for (TimedPose& pose : scene.poses) pose.T_v0 = sensor.T_bv.inverse() * pose.T_v0;
  return scene;
}

// One recording after the other, of the same traffic. Interrupted, the later ones are missing or shorter.
int simulate_rig(const SimulateOptions& options) {
  const std::vector<RigSensor> sensors = read_rig_yaml(options.rig);
  std::vector<std::shared_ptr<const LidarModel>> models;
  for (const RigSensor& sensor : sensors) {
    if (sensor.clock_offset != Duration()) {
      throw ParameterError({"--rig", "clock_offset_s", fmt::format("{}", sensor.clock_offset.seconds()),
                            "not 0: simulated sensors have one clock", "leave it out"});
    }
    models.push_back(std::make_shared<const LidarModel>(
        model_from_name_or_file(sensor.model.empty() ? options.sensor : sensor.model)));
  }
  say("mapless: building {}\n", options.scene);
  const Scene scene = make_scene(options.scene, options.making);
  SimulatedWorld world(scene.world);
  const std::filesystem::path folder(options.output);
  const InterruptGuard interrupt;
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    const Scene mine = seen_by(scene, sensors[k]);
    const int count = scans_within(options, *models[k]);
    const auto writer = make_sequence_writer(options.format, folder / sensors[k].name, models[k], mine);
    const auto trajectory =
        std::make_shared<const SampledTrajectory>(mine.poses, Duration(), "trajectory of the scene");
    SensorOptions sensing = options.sensing;
    sensing.seed += kSeedsApart * k;
    SimulatedSensor sensor(models[k], trajectory, world, sensing);
    const RoomForTheEnd room(folder / sensors[k].name / "room_for_the_end", bytes_at_the_end(mine, count));
    const int done = write_scans(sensor, *writer, room, count);
    if (done < count) {
      say("mapless: interrupted after {} finished scans of {}\n", done, sensors[k].name);
      return InterruptGuard::exit_code();
    }
    fmt::print("{} scans of {} ({}, {})\n", done, sensors[k].name, models[k]->name, options.format);
  }
  write_rig_yaml(folder / kRigFile, sensors);
  fmt::print("result in {}\n", options.output);
  return 0;
}

int simulate(SimulateOptions options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  require_new(options.output);
  options.making.arbitrary_world = options.world == "arbitrary";
  options.sensing.seed = options.making.seed;
  options.sensing.faulty = options.faulty == "on";
  if (!options.rig.empty()) return simulate_rig(options);
  const auto model = std::make_shared<const LidarModel>(
      model_for_format(model_from_name_or_file(options.sensor), options.format));
  const int count = scans_within(options, *model);
  say("mapless: building {}\n", options.scene);
  const Scene scene = make_scene(options.scene, options.making);
  const auto writer = make_sequence_writer(options.format, options.output, model, scene);
  const auto trajectory =
      std::make_shared<const SampledTrajectory>(scene.poses, Duration(), "trajectory of the scene");
  SimulatedWorld world(scene.world);
  SimulatedSensor sensor(model, trajectory, world, options.sensing);

  const RoomForTheEnd room(std::filesystem::path(options.output) / "room_for_the_end",
                           bytes_at_the_end(scene, count));
  const InterruptGuard interrupt;
  double seconds = 0;
  const int done = timed(seconds, [&] { return write_scans(sensor, *writer, room, count); });
  if (done < count) {
    say("mapless: interrupted after {} finished scans; they are a valid shorter sequence\n", done);
    return InterruptGuard::exit_code();
  }
  fmt::print("{} scans of {} ({}, {}), {:.1f} scans/s\nresult in {}\n", done, options.scene, model->name,
             options.format, done / seconds, options.output);
  return 0;
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "simulate",
      "Simulate a drive through a scene and write it as a recording, with the true label of every point");
  const auto options = std::make_shared<SimulateOptions>();
  verb->add_option("SCENE", options->scene, fmt::format("one of {}", fmt::join(scene_names(), ", ")))
      ->required()
      ->check(CLI::IsMember(scene_names()));
  verb->add_option("-o,--output", options->output, "folder for the recording; must not exist")->required();
  verb->add_option("--sensor", options->sensor,
                   "a named model, or a calibration file: Velodyne's YAML, Ouster's JSON, Hesai's CSV, or a "
                   "sensor.yaml")
      ->capture_default_str();
  verb->add_option(
          "--rig", options->rig,
          "several sensors on one vehicle, of a rig.yaml with the model and the place of each: writes "
          "a recording of each, and rig.yaml, for mapless detect. The frame of the vehicle is that of "
          "the scene's own sensor")
      ->check(not_empty());
  verb->add_option(
          "--duration-s", options->making.duration_s,
          "duration [s], at most 600. A longer recording of the same seed begins with the shorter one")
      ->check(positive_number())
      ->capture_default_str();
  verb->add_option("--seed", options->making.seed, "seed of the random scene, traffic and noise")
      ->check(whole_number(0))
      ->capture_default_str();
  verb->add_option("--range-noise-m", options->sensing.range_noise_m, "standard deviation of the ranges [m]")
      ->check(number_between(0, 1))
      ->capture_default_str();
  verb->add_option("--faulty", options->faulty,
                   "simulate missing returns from glass, dark paint and distant ground")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  verb->add_option("--format", options->format, "format of the recording")
      ->check(CLI::IsMember(sequence_formats()))
      ->capture_default_str();
  verb->add_option("--world", options->world, "world frame: rotated arbitrarily, or level with z up")
      ->check(CLI::IsMember({"arbitrary", "level"}))
      ->capture_default_str();
  verb->add_option("--threads", options->threads,
                   "number of threads (default: all cores). The recording does not depend on it")
      ->check(CLI::Range(1, 1024));
  verb->callback([options, &exit_code] { exit_code = simulate(*options); });
}

}  // namespace mapless::app
