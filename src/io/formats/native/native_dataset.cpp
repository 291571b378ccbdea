#include "io/formats/native/native_dataset.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "io/files/numbered_files.hpp"
#include "io/formats/pcd/pcd.hpp"
#include "io/tables/scan_times.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Rounded down, so that a scan does not end after the next one's start.
Duration column_period(const LidarModel& model) {
  return Duration::from_nanoseconds(
      static_cast<std::int64_t>(1e9 / (model.rotation_rate_hz * model.columns)));
}

void require_size_of_model(const PcdCloud& cloud, const LidarModel& model) {
  const auto require = [&](const char* field, std::size_t found, std::size_t expected, const char* what) {
    if (found == expected) return;
    throw InputError({cloud.file.string(), field, std::to_string(found),
                      fmt::format("not the {} {} of sensor {}", expected, what, model.name),
                      "a scan of another sensor or mode belongs into another recording"});
  };
  require("HEIGHT", cloud.height, model.lasers.size(), "lasers");
  require("WIDTH", cloud.width, static_cast<std::size_t>(model.columns), "columns");
}

// A file that was cut and filled up with zeros, as copying to a full disk or a power cut leave it. Sensors
// without a return give a time, or NaN.
void require_not_padded(const PcdCloud& cloud) {
  const std::size_t size = cloud.size() == 0 ? 0 : cloud.bytes.size() / cloud.size();
  std::size_t zeros =
      cloud.bytes.size() - std::min(cloud.bytes.find_last_not_of('\0') + 1, cloud.bytes.size());
  if (size == 0 || zeros / size < cloud.width || cloud.find("t") == nullptr) return;
  throw InputError({cloud.file.string(), "points", fmt::format("{}", cloud.size()),
                    fmt::format("the last {} are zeros: the file was cut, and filled up", zeros / size),
                    "copy the recording again"});
}

std::int64_t nominal_time_ns(const LidarModel& model, Duration period, const LidarRecord& r) {
  return r.column * period.nanoseconds() +
         model.lasers[static_cast<std::size_t>(r.laser)].firing_offset.nanoseconds();
}

std::vector<ReturnCode> read_codes(const PcdCloud& cloud) {
  // Without a code, a missing return proves nothing; organise() makes those of NaN faulty.
  const PcdField* field = cloud.find("code");
  if (field == nullptr) return std::vector<ReturnCode>(cloud.size(), ReturnCode::hit);
  std::vector<ReturnCode> codes;
  codes.reserve(cloud.size());
  for (const std::int64_t code : cloud.integers(*field)) {
    if (code < 0 || code > 2) {
      throw InputError({cloud.file.string(), fmt::format("point {} code", codes.size()), std::to_string(code),
                        "not 0 (hit), 1 (faulty or unknown) or 2 (nothing within range)",
                        "correct the scan"});
    }
    codes.push_back(static_cast<ReturnCode>(code));
  }
  return codes;
}

std::vector<LidarRecord> read_records(const PcdCloud& cloud) {
  const std::vector<float> x = cloud.floats(cloud.require("x")), y = cloud.floats(cloud.require("y")),
                           z = cloud.floats(cloud.require("z"));
  const std::vector<ReturnCode> codes = read_codes(cloud);
  std::vector<LidarRecord> records(cloud.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Eigen::Vector3f position(x[i], y[i], z[i]);
    if (codes[i] == ReturnCode::nothing && position.allFinite() && !position.isZero()) {
      throw InputError({cloud.file.string(), fmt::format("point {} code", i), "2",
                        fmt::format("says that nothing is within range, and the point is {:.3f} m away",
                                    position.cast<double>().norm()),
                        "give code 0 to points, and NaN where there is none"});
    }
    records[i] = {position, static_cast<std::int32_t>(i / cloud.width),
                  static_cast<std::int32_t>(i % cloud.width), 0, codes[i]};
  }
  return records;
}

void set_times(std::vector<LidarRecord>& records, const PcdCloud& cloud, const PcdField& field) {
  const std::vector<std::int64_t> times = cloud.integers(field);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].code != ReturnCode::hit) continue;
    if (!std::in_range<std::int32_t>(times[i])) {
      throw InputError({cloud.file.string(), fmt::format("point {} t", i), std::to_string(times[i]),
                        "not within 2 s of the scan's start",
                        "give t in nanoseconds since the scan's start"});
    }
    records[i].time_ns = static_cast<std::int32_t>(times[i]);
  }
}

class NativeDataset final : public Dataset {
 public:
  NativeDataset(const fs::path& folder, const DatasetOptions& options) : folder_(folder) {
    const fs::path sensor = folder / "sensor.yaml";
    model_ = std::make_shared<LidarModel>(options.sensor.empty() ? read_sensor_yaml(sensor)
                                                                 : model_from_name_or_file(options.sensor));
    const std::map<int, fs::path> scans = numbered_files(folder / "scans", ".pcd");
    for (const auto& [number, file] : scans) scans_.push_back(file);
    if (scans_.empty()) {
      throw InputError(
          {(folder / "scans").string(), "scans", "0", "no NNNNNN.pcd in it", "give a recording with scans"});
    }
    starts_ = read_scan_times(folder / "times.txt", scans_.size());
    find_labels(options);
    notes_.push_back("times: of each scan from times.txt");
    if (has_trajectory())
      notes_.push_back("trajectory: the recording's own trajectory.txt, world from sensor");
    const std::string missing = missing_numbers(scans);
    if (!missing.empty()) notes_.push_back("scan numbers missing: " + missing);
  }

  [[nodiscard]] std::string format() const override { return "native"; }
  [[nodiscard]] std::size_t size() const override { return scans_.size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return model_; }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return starts_[checked(k)]; }
  [[nodiscard]] Time scan_end(std::size_t k) const override {
    return starts_[checked(k)] +
           Duration::from_nanoseconds(model_->columns * column_period(*model_).nanoseconds());
  }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return scans_[checked(k)]; }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    const PcdCloud cloud = read_pcd(scans_[checked(k)]);
    require_size_of_model(cloud, *model_);
    require_not_padded(cloud);
    LidarScan scan;
    scan.model = model_;
    scan.start = starts_[k];
    scan.column_period = column_period(*model_);
    scan.columns = model_->columns;
    scan.ring_source = Provenance::sensor;
    std::vector<LidarRecord> records = read_records(cloud);
    if (const PcdField* t = cloud.find("t"); t != nullptr) {
      set_times(records, cloud, *t);
      scan.time_source = Provenance::sensor;
    } else {
      for (LidarRecord& r : records) {
        r.time_ns = static_cast<std::int32_t>(nominal_time_ns(*model_, scan.column_period, r));
      }
      scan.time_source = Provenance::recovered_from_order;
    }
    return organise(std::move(scan), records, scans_[k].string());
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    const fs::path file = labels_ / scans_[checked(k)].filename().replace_extension(".label");
    if (labels_.empty() || !fs::exists(file)) return std::nullopt;
    return read_label_file(file, model_->lasers.size() * static_cast<std::size_t>(model_->columns));
  }

  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override {
    if (!has_trajectory()) return nullptr;
    return std::make_shared<SampledTrajectory>(read_trajectory_file(folder_ / "trajectory.txt", {}));
  }

 private:
  [[nodiscard]] bool has_trajectory() const { return fs::exists(folder_ / "trajectory.txt"); }

  void find_labels(const DatasetOptions& options) {
    if (!options.labels.empty() && !fs::is_directory(options.labels)) {
      throw InputError(
          {options.labels.string(), "labels", "", "not a folder", "give the folder of the label files"});
    }
    labels_ = options.labels.empty() ? folder_ / "labels" : options.labels;
    if (fs::is_directory(labels_)) {
      notes_.push_back("labels: " + labels_.string());
    } else {
      labels_.clear();
    }
  }

  fs::path folder_;
  fs::path labels_;  // empty: none
  std::shared_ptr<const LidarModel> model_;
  std::vector<fs::path> scans_;
  std::vector<Time> starts_;
  std::vector<std::string> notes_;
};

}  // namespace

bool looks_native(const fs::path& path) {
  return fs::is_regular_file(path / "sensor.yaml") && fs::is_directory(path / "scans");
}

std::unique_ptr<Dataset> open_native(const fs::path& path, const DatasetOptions& options) {
  return std::make_unique<NativeDataset>(path, options);
}

}  // namespace mapless
