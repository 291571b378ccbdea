#include "benchmark/recording_store.hpp"

#include <cmath>
#include <memory>
#include <span>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "reports/digest.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "terminal/interrupt.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kManifest = "manifest.json";

/// A scene with the sensor in it, ready to be cast.
class Simulation {
 public:
  explicit Simulation(const RecordingKey& key)
      : scene_(make_scene(key.scene, {key.seed, key.duration_s, true})),
        model_(std::make_shared<const LidarModel>(key.model())),
        world_(scene_.world),
        sensor_(
            model_,
            std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), "trajectory of the scene"),
            world_, {key.range_noise_m, key.faulty, key.seed}) {}

  [[nodiscard]] SimulatedScan scan(std::size_t k) { return sensor_.scan(static_cast<int>(k)); }
  [[nodiscard]] std::unique_ptr<SequenceWriter> writer(const fs::path& folder) const {
    return make_sequence_writer("native", folder, model_, scene_);
  }
  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
  std::shared_ptr<const LidarModel> model_;
  SimulatedWorld world_;
  SimulatedSensor sensor_;
};

void add(Digest& digest, const SimulatedScan& scan) {
  for (const LidarRecord& r : scan.records) {
    for (int i = 0; i < 3; ++i) digest.add(std::isnan(r.position_v[i]) ? 0.0F : r.position_v[i]);
    digest.add(r.time_ns);
    digest.add(r.code);
  }
  for (const std::uint32_t label : scan.labels) digest.add(label);
}

std::string digest_of(const Scene& scene, const SimulatedScan& first, const SimulatedScan& last) {
  Digest digest;
  add(digest, first);
  add(digest, last);
  for (const TimedPose& pose : scene.poses_in_world()) {
    digest.add(pose.time.nanoseconds());
    for (int i = 0; i < 3; ++i) digest.add(pose.T_v0.translation()[i]);
  }
  return digest.text();
}

std::string manifest_text(const RecordingKey& key, const std::string& digest) {
  Json manifest = key.json();
  manifest["scans"] = RecordingStore::scans(key);
  manifest["digest"] = digest;
  return json_text(manifest);
}

/// A folder that is gone again unless it was kept.
class FolderInTheMaking {
 public:
  explicit FolderInTheMaking(fs::path path) : path_(std::move(path)) {}
  ~FolderInTheMaking() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(path_, ignored);
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  void keep_as(const fs::path& name) {
    std::error_code error;
    fs::remove_all(name, error);
    if (!error) fs::rename(path_, name, error);
    if (error)
      throw_write_error({name.string(), "", "", error.message(), "check the folder and the disk"}, error);
    kept_ = true;
  }

 private:
  fs::path path_;
  bool kept_ = false;
};

}  // namespace

std::size_t RecordingStore::scans(const RecordingKey& key) {
  if (key.duration_s > kMaxSceneDuration_s) {
    throw ParameterError({"--duration-s", "", fmt::format("{}", key.duration_s), "too long",
                          fmt::format("give at most {}, or several seeds", kMaxSceneDuration_s)});
  }
  const double rate_hz = key.model().rotation_rate_hz;
  const auto count = std::floor(key.duration_s * rate_hz + 1e-6);
  if (count < 1) {
    throw ParameterError({"--duration-s", "", fmt::format("{}", key.duration_s), "shorter than one scan",
                          fmt::format("give at least {}", 1 / rate_hz)});
  }
  return static_cast<std::size_t>(count);
}

bool RecordingStore::has(const RecordingKey& key) const {
  if (!fs::exists(path(key))) return false;
  if (!fs::exists(path(key) / kManifest)) {
    throw OutputError({path(key).string(), kManifest, "",
                       "is not there: this is no recording of the benchmark",
                       "choose another folder for the recordings, or remove it"});
  }
  Simulation simulation(key);
  const SimulatedScan first = simulation.scan(0), last = simulation.scan(scans(key) - 1);
  return read_whole_file(path(key) / kManifest) ==
         manifest_text(key, digest_of(simulation.scene(), first, last));
}

bool RecordingStore::make(const RecordingKey& key, const std::function<void()>& scan_done) const {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error)
    throw_write_error({folder_.string(), "", "", "cannot be made: " + error.message(), "check the folder"},
                      error);
  FolderInTheMaking folder(folder_ / fmt::format(".{}.partial-{}", key.name(), getpid()));
  Simulation simulation(key);
  const auto writer = simulation.writer(folder.path());
  SimulatedScan first, last;
  for (std::size_t k = 0; k < scans(key); ++k) {
    if (InterruptGuard::requested()) return false;
    last = simulation.scan(k);
    if (k == 0) first = last;
    writer->add(last);
    scan_done();
  }
  writer->finish();
  write_file_atomically(folder.path() / kManifest,
                        manifest_text(key, digest_of(simulation.scene(), first, last)));
  folder.keep_as(path(key));
  return true;
}

}  // namespace mapless::app
