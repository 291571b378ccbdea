#include "io/formats/pcd/pcd_folder_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/formats/pcd/pcd_fields.hpp"
#include "io/tables/scan_times.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/lidar/scan_builder.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Enough for the fit of a cone per laser, few enough to open a recording in a second or two.
constexpr std::size_t kScansForSensor = 8;
// The rate of a spinning lidar is within 10 % of its nominal one.
constexpr double kPeriodTolerance = 0.1;

std::vector<fs::path> pcd_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".pcd" && entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// A Unix time in nanoseconds has 18 or 19 digits, one in seconds at most 10, with or without decimals.
std::optional<Time> time_of_name(const fs::path& file) {
  const std::string name = file.stem().string();
  const bool whole = name.find('.') == std::string::npos;
  if (whole && (name.size() == 18 || name.size() == 19)) {
    const auto ns = parse_integer(name);
    return ns ? std::optional(Time::from_nanoseconds(*ns)) : std::nullopt;
  }
  // Shorter names are numbers of scans.
  const bool seconds =
      name.find_first_not_of("0123456789.") == std::string::npos && (!whole || name.size() == 10);
  return seconds ? parse_decimal_seconds(name) : std::nullopt;
}

std::optional<std::vector<Time>> times_of_names(const std::vector<fs::path>& files) {
  std::vector<Time> times;
  for (const fs::path& file : files) {
    const std::optional<Time> time = time_of_name(file);
    if (!time) return std::nullopt;
    times.push_back(*time);
  }
  return times;
}

std::vector<Time> times_of_points(const std::vector<fs::path>& files) {
  std::vector<Time> times;
  for (const fs::path& file : files) {
    const std::optional<Time> first = first_time(read_pcd(file));
    if (!first) {
      throw InputError({file.string(), "start", "", "the scan has no time",
                        "put a times.txt beside the scans, with the start of one scan in seconds per line"});
    }
    times.push_back(*first);
  }
  return times;
}

void require_increasing(const std::vector<Time>& times, const std::vector<fs::path>& files) {
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) continue;
    throw InputError({files[k].string(), "start", fmt::format("{} ns", times[k].nanoseconds()),
                      fmt::format("not after the scan before it ({} ns)", times[k - 1].nanoseconds()),
                      "put the scans in order, or give their starts in times.txt"});
  }
}

// Scans all over the recording. Those that cannot be read say so when they are read.
std::vector<PcdCloud> scans_for_sensor(const std::vector<fs::path>& files) {
  std::set<std::size_t> chosen;
  const std::size_t last = files.size() - 1;
  for (std::size_t i = 0; i < kScansForSensor; ++i) chosen.insert(i * last / (kScansForSensor - 1));
  std::vector<PcdCloud> scans;
  for (const std::size_t k : chosen) {
    try {
      PcdCloud cloud = read_pcd(files[k]);
      (void)first_time(cloud);  // checks rings and times, too
      scans.push_back(std::move(cloud));
    } catch (const InputError&) {
      if (k == last && scans.empty()) throw;
    }
  }
  return scans;
}

ScanBuilder recovered_builder(const std::vector<fs::path>& files, const std::vector<Time>& starts,
                              const std::string& folder) {
  const std::vector<PcdCloud> clouds = scans_for_sensor(files);
  std::vector<PointFields> scans;
  for (const PcdCloud& cloud : clouds) scans.push_back(fields_of(cloud));
  return ScanBuilder::recover(scans, starts, folder);
}

class PcdFolderDataset final : public Dataset {
 public:
  PcdFolderDataset(const fs::path& folder, const DatasetOptions& options) : files_(pcd_files(folder)) {
    if (files_.empty()) {
      throw InputError({folder.string(), "scans", "0", "no *.pcd in it", "give the folder of the scans"});
    }
    find_times(folder);
    builder_ = options.sensor.empty() ? recovered_builder(files_, starts_, folder.string())
                                      : ScanBuilder(model_from_name_or_file(options.sensor));
    for (std::string& note : builder_->notes()) notes_.push_back(std::move(note));
    notes_.push_back("points are taken as measured, not motion-compensated: PCD files do not define this");
    find_turn();
    labels_ = options.labels.empty() ? folder / "labels" : options.labels;
    if (!options.labels.empty() && !fs::is_directory(labels_)) {
      throw InputError(
          {labels_.string(), "labels", "", "not a folder", "give the folder of the label files"});
    }
  }

  [[nodiscard]] std::string format() const override { return "pcd"; }
  [[nodiscard]] std::size_t size() const override { return files_.size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return builder_->model(); }
  [[nodiscard]] std::optional<ModelEstimate> model_estimate() const override { return builder_->estimate(); }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return starts_[checked(k)]; }
  [[nodiscard]] Time scan_end(std::size_t k) const override { return starts_[checked(k)] + turn_; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return files_[checked(k)]; }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    const PcdCloud cloud = read_pcd(files_[checked(k)]);
    return builder_->build(fields_of(cloud), starts_[k], files_[k].string());
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    const fs::path file = labels_ / files_[checked(k)].filename().replace_extension(".label");
    if (!fs::exists(file)) return std::nullopt;
    return read_label_file(file, read_pcd(files_[k]).size());
  }

 private:
  void find_times(const fs::path& folder) {
    if (fs::exists(folder / "times.txt")) {
      starts_ = read_scan_times(folder / "times.txt", files_.size());
      notes_.push_back("times: of each scan from times.txt");
    } else if (auto times = times_of_names(files_)) {
      starts_ = std::move(*times);
      notes_.push_back("times: of each scan from the names of the files, as Unix times of its start");
    } else {
      starts_ = times_of_points(files_);
      notes_.push_back("times: of each scan from its earliest point");
    }
    require_increasing(starts_, files_);
  }

  // The median period between scans, if it is that of the sensor to 10 %; scans may have been removed.
  void find_turn() {
    const double nominal_s = 1 / builder_->model()->rotation_rate_hz;
    turn_ = Duration::from_seconds(nominal_s);
    std::vector<Duration> steps;
    for (std::size_t k = 1; k < starts_.size(); ++k) steps.push_back(starts_[k] - starts_[k - 1]);
    if (steps.empty()) return;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double ratio = middle->seconds() / nominal_s;
    if (std::abs(ratio - 1) < kPeriodTolerance) turn_ = *middle;
    builder_->set_turn_duration(turn_);
  }

  std::vector<fs::path> files_;
  fs::path labels_;
  std::optional<ScanBuilder> builder_;
  std::vector<Time> starts_;
  Duration turn_;
  std::vector<std::string> notes_;
};

}  // namespace

bool looks_pcd_folder(const fs::path& path) {
  return !fs::exists(path / "sensor.yaml") && !pcd_files(path).empty();
}

std::unique_ptr<Dataset> open_pcd_folder(const fs::path& path, const DatasetOptions& options) {
  return std::make_unique<PcdFolderDataset>(path, options);
}

}  // namespace mapless
