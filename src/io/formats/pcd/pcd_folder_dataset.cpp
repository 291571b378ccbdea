#include "io/formats/pcd/pcd_folder_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/formats/pcd/pcd_points.hpp"
#include "io/formats/pcd/pcd_sensor.hpp"
#include "io/tables/scan_times.hpp"
#include "lidar/nearest_beam.hpp"
#include "lidar/ring_recovery.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Bounds of beam_misfit [steps of elevation] for rings found from elevations (random points give 0.25), and
// for rings that the recording states: real elevations may differ from the nominal ones by a step.
constexpr double kLargestMisfitFound = 0.15;
constexpr double kLargestMisfitStated = 1.0;
// The rate of a spinning lidar is within 10 % of its nominal one.
constexpr double kPeriodTolerance = 0.1;
// A point cannot be measured more than this many turns after the first one of its scan.
constexpr std::int64_t kMostTurns = 3;

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
    const PcdPoints points = read_pcd_points(file);
    const std::optional<std::int64_t> first = points.first_time_ns();
    if (!first || !points.times_are_absolute) {
      throw InputError({file.string(), "start", "", "the scan has no time",
                        "put a times.txt beside the scans: the start of each scan in seconds, one per line"});
    }
    times.push_back(Time::from_nanoseconds(*first));
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

std::vector<std::int32_t> stated_lasers(const PcdPoints& points, const LidarModel& model,
                                        const std::string& source) {
  const auto count = static_cast<std::int64_t>(model.lasers.size());
  std::vector<std::int32_t> lasers(points.rings.size(), 0);
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    const bool inside = points.rings[i] >= 0 && points.rings[i] < count;
    if (!inside && is_usable(points.positions[i])) {
      throw InputError({source, fmt::format("point {} ring", i), std::to_string(points.rings[i]),
                        fmt::format("not one of the {} lasers of {}", count, model.name),
                        "name the sensor it is of"});
    }
    if (inside) lasers[i] = static_cast<std::int32_t>(points.rings[i]);
  }
  // Some vendors count from the top.
  std::vector<std::int32_t> reversed = lasers;
  for (std::int32_t& laser : reversed) laser = static_cast<std::int32_t>(count) - 1 - laser;
  const bool from_top =
      beam_misfit(points.positions, reversed, model) < beam_misfit(points.positions, lasers, model);
  return from_top ? reversed : lasers;
}

void require_fit(double misfit, double largest, const LidarModel& model, const std::string& source) {
  if (misfit <= largest) return;
  throw InputError(
      {source, "sensor", model.name,
       fmt::format("half of the points lie more than {:.2f} laser spacings off its beams", misfit),
       "name the sensor of the recording, or its calibration file"});
}

// Moves each column, known modulo a turn, to the turn of the point's time, with column 0 at the earliest
// point, and gives the scan a model that starts there: scans may begin at any azimuth.
void unwind(LidarScan& scan, std::vector<LidarRecord>& records, const PcdPoints& points,
            std::int64_t first_ns) {
  const auto model = std::make_shared<LidarModel>(*scan.model);
  const int turn = model->columns;
  std::size_t first = 0;
  while (!is_usable(points.positions[first]) || points.times_ns[first] != first_ns) ++first;
  const int first_column = records[first].column;
  model->start_azimuth_rad = model->hub_angle(first_column);
  for (std::size_t i = 0; i < records.size(); ++i) {
    LidarRecord& r = records[i];
    if (r.code != ReturnCode::hit) {
      r.column = 0;
      continue;
    }
    const double expected =
        static_cast<double>(r.time_ns) / static_cast<double>(scan.column_period.nanoseconds());
    const int column = r.column - first_column;
    const int turns = static_cast<int>(std::lround((expected - column) / turn));
    r.column = std::max(0, column + turns * turn);
    scan.columns = std::max(scan.columns, r.column + 1);
  }
  scan.model = model;
}

class PcdFolderDataset final : public Dataset {
 public:
  PcdFolderDataset(const fs::path& folder, const DatasetOptions& options) : files_(pcd_files(folder)) {
    if (files_.empty()) {
      throw InputError({folder.string(), "scans", "0", "no *.pcd in it", "give the folder of the scans"});
    }
    find_times(folder);
    if (options.sensor.empty()) {
      estimated_ = estimate_pcd_sensor(files_, starts_, folder.string());
      model_ = std::make_shared<LidarModel>(estimated_->model);
      notes_.insert(notes_.end(), estimated_->notes.begin(), estimated_->notes.end());
    } else {
      model_ = std::make_shared<LidarModel>(model_from_name_or_file(options.sensor));
    }
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
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return model_; }
  [[nodiscard]] std::optional<ModelEstimate> model_estimate() const override {
    return estimated_ ? std::optional(estimated_->estimate) : std::nullopt;
  }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return starts_[checked(k)]; }
  [[nodiscard]] Time scan_end(std::size_t k) const override { return starts_[checked(k)] + turn_; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return files_[checked(k)]; }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    const std::string source = files_[checked(k)].string();
    const PcdPoints points = read_pcd_points(files_[k]);
    LidarScan scan;
    scan.model = model_;
    scan.start = starts_[k];
    scan.columns = model_->columns;
    scan.column_period = Duration::from_nanoseconds(turn_.nanoseconds() / model_->columns);
    const std::vector<std::int32_t> lasers = lasers_of(points, scan, source);
    const RecoveredFirings firings =
        recover_firings(points.positions, lasers, *model_, estimated_ ? estimated_->layout.encoder_steps : 0);
    std::vector<LidarRecord> records(points.positions.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
      const Duration offset = model_->lasers[static_cast<std::size_t>(lasers[i])].firing_offset;
      const auto time_ns = static_cast<std::int32_t>(firings.columns[i] * scan.column_period.nanoseconds() +
                                                     offset.nanoseconds());
      // The direction of a point without position is unknown: it has no cell.
      const ReturnCode code = is_usable(points.positions[i]) ? ReturnCode::hit : ReturnCode::absent;
      records[i] = {points.positions[i], lasers[i], firings.columns[i], time_ns, code};
    }
    scan.time_source = Provenance::recovered_from_angle;
    if (const auto first_ns = points.first_time_ns()) {
      take_times(scan, records, points, *first_ns, source);
      unwind(scan, records, points, *first_ns);
    }
    return organise(std::move(scan), records, source);
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    const fs::path file = labels_ / files_[checked(k)].filename().replace_extension(".label");
    if (!fs::exists(file)) return std::nullopt;
    return read_label_file(file, read_pcd_points(files_[k]).positions.size());
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
    const double nominal_s = 1 / model_->rotation_rate_hz;
    turn_ = Duration::from_seconds(nominal_s);
    std::vector<Duration> steps;
    for (std::size_t k = 1; k < starts_.size(); ++k) steps.push_back(starts_[k] - starts_[k - 1]);
    if (steps.empty()) return;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double ratio = middle->seconds() / nominal_s;
    if (std::abs(ratio - 1) < kPeriodTolerance) turn_ = *middle;
  }

  [[nodiscard]] std::vector<std::int32_t> lasers_of(const PcdPoints& points, LidarScan& scan,
                                                    const std::string& source) const {
    if (estimated_ || !points.rings.empty()) {
      std::vector<std::int32_t> lasers =
          estimated_ ? lasers_by_rings(points, *estimated_, source) : stated_lasers(points, *model_, source);
      require_fit(beam_misfit(points.positions, lasers, *model_), kLargestMisfitStated, *model_, source);
      const bool stated = !estimated_ || estimated_->rings_from == PcdRingSource::field;
      scan.ring_source = stated ? Provenance::sensor : Provenance::recovered_from_order;
      return lasers;
    }
    BeamAssignment found = nearest_beams(points.positions, *model_);
    require_fit(found.misfit, kLargestMisfitFound, *model_, source);
    scan.ring_source = Provenance::recovered_from_angle;
    return std::move(found.lasers);
  }

  // With times per point the scan starts at its earliest point.
  static void take_times(LidarScan& scan, std::vector<LidarRecord>& records, const PcdPoints& points,
                         std::int64_t first_ns, const std::string& source) {
    const std::int64_t longest_ns = kMostTurns * scan.columns * scan.column_period.nanoseconds();
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (records[i].code != ReturnCode::hit) continue;
      const std::int64_t since_first = points.times_ns[i] - first_ns;
      if (since_first > longest_ns || since_first > INT32_MAX) {
        throw InputError({source, fmt::format("point {} time", i), fmt::format("{} ns", points.times_ns[i]),
                          fmt::format("{} ns after the first point: more than three turns", since_first),
                          "give times in nanoseconds (integers) or seconds (floating)"});
      }
      records[i].time_ns = static_cast<std::int32_t>(since_first);
    }
    scan.start = points.times_are_absolute ? Time::from_nanoseconds(first_ns)
                                           : scan.start + Duration::from_nanoseconds(first_ns);
    scan.time_source = Provenance::sensor;
  }

  std::vector<fs::path> files_;
  fs::path labels_;
  std::shared_ptr<const LidarModel> model_;
  std::optional<PcdSensor> estimated_;
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
