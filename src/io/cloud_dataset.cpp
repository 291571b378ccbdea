#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/time_check.hpp"
#include "lidar/scan_builder/raw_points.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/lidar/scan_builder.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Enough for the fit of a cone per laser, few enough to open a recording in a second or two.
constexpr std::size_t kScansForSensor = 8;
// The rate of a spinning lidar is within 10 % of its nominal one.
constexpr double kPeriodTolerance = 0.1;

// Scans all over the recording. Those that cannot be read say so when they are read.
std::vector<Cloud> scans_for_sensor(const CloudSource& source) {
  std::set<std::size_t> chosen;
  const std::size_t last = source.starts().size() - 1;
  for (std::size_t i = 0; i < kScansForSensor; ++i) chosen.insert(i * last / (kScansForSensor - 1));
  std::vector<Cloud> scans;
  for (const std::size_t k : chosen) {
    try {
      Cloud cloud = source.read(k);
      (void)read_points(cloud.fields,
                        source.scan_file(k).string());  // throws where recovery would, for this scan alone
      scans.push_back(std::move(cloud));
    } catch (const InputError&) {
      if (k == last && scans.empty()) throw;
    }
  }
  return scans;
}

std::shared_ptr<const CloudSource> with_sane_starts(std::shared_ptr<const CloudSource> source) {
  const std::vector<Time>& starts = source->starts();
  for (std::size_t k = 0; k < starts.size(); ++k)
    require_time(source->scan_file(k).string(), "start", starts[k]);
  return source;
}

ScanBuilder builder_for(const CloudSource& source, const std::string& sensor) {
  if (!sensor.empty()) return ScanBuilder(model_from_name_or_file(sensor));
  const std::vector<Cloud> clouds = scans_for_sensor(source);
  std::vector<PointFields> scans;
  for (const Cloud& cloud : clouds) scans.push_back(cloud.fields);
  return ScanBuilder::recover(scans, source.starts(), source.path().string());
}

struct FieldsThere {
  bool ring = false, time = false;
};

FieldsThere fields_there(const PointFields& fields) { return {fields.ring.size > 0, fields.time.size > 0}; }

bool is_empty(const Cloud& cloud) { return cloud.fields.x.size == 0; }

// Of the first scan that can be read and has points. A scan without times among scans with them would get
// others.
std::optional<FieldsThere> fields_of_first(const CloudSource& source) {
  for (std::size_t k = 0; k < std::min(source.starts().size(), kScansForSensor); ++k) {
    try {
      const Cloud cloud = source.read(k);
      if (!is_empty(cloud)) return fields_there(cloud.fields);
    } catch (const InputError&) {  // the run says so when it reaches the scan
    }
  }
  return std::nullopt;
}

class CloudDataset final : public Dataset {
 public:
  CloudDataset(std::shared_ptr<const CloudSource> source, const std::string& sensor)
      : source_(with_sane_starts(std::move(source))),
        builder_(builder_for(*source_, sensor)),
        fields_(fields_of_first(*source_)),
        notes_(source_->notes()) {
    for (std::string& note : builder_.notes()) notes_.push_back(std::move(note));
    find_turn();
  }

  [[nodiscard]] std::string format() const override { return source_->format(); }
  [[nodiscard]] std::size_t size() const override { return source_->starts().size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return builder_.model(); }
  [[nodiscard]] std::optional<ModelEstimate> model_estimate() const override { return builder_.estimate(); }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return source_->starts()[checked(k)]; }
  [[nodiscard]] Time scan_end(std::size_t k) const override { return scan_start(k) + turn_; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return source_->scan_file(checked(k)); }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override {
    return source_->trajectory();
  }
  [[nodiscard]] std::vector<MotionMeasurement> measurements() const override {
    return source_->measurements();
  }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    const Cloud cloud = source_->read(checked(k));
    require_same_fields(cloud, k);
    LidarScan scan = builder_.build(cloud.fields, cloud.stamp, source_->scan_file(k).string());
    scan.compensated_to = cloud.compensated_to;
    return scan;
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    return source_->read_labels(checked(k));
  }

 private:
  void require_same_fields(const Cloud& cloud, std::size_t k) const {
    if (is_empty(cloud)) return;
    const FieldsThere own = fields_there(cloud.fields), first = fields_.value_or(own);
    if (own.ring == first.ring && own.time == first.time) return;
    const bool differs_in_time = own.time != first.time, has = differs_in_time ? own.time : own.ring;
    throw InputError({source_->scan_file(k).string(), "fields", "",
                      std::string("has ") + (has ? "a" : "no") +
                          (differs_in_time ? " time of each point" : " laser (ring) of each point") +
                          (has ? ", and the scans before it have none" : ", which the scans before it have"),
                      "give all scans the same fields"});
  }

  // The median period between scans, if it is that of the sensor to 10 %; scans may have been removed.
  void find_turn() {
    const double nominal_s = 1 / builder_.model()->rotation_rate_hz;
    turn_ = Duration::from_seconds(nominal_s);
    const std::vector<Time>& starts = source_->starts();
    std::vector<Duration> steps;
    for (std::size_t k = 1; k < starts.size(); ++k) steps.push_back(starts[k] - starts[k - 1]);
    if (steps.empty()) return;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double ratio = middle->seconds() / nominal_s;
    if (std::abs(ratio - 1) < kPeriodTolerance) turn_ = *middle;
    builder_.set_turn_duration(turn_);
  }

  std::shared_ptr<const CloudSource> source_;
  ScanBuilder builder_;
  std::optional<FieldsThere> fields_;
  std::vector<std::string> notes_;
  Duration turn_;
};

}  // namespace

std::optional<std::vector<std::uint32_t>> CloudSource::read_labels(std::size_t /*k*/) const {
  return std::nullopt;
}

std::unique_ptr<Dataset> make_cloud_dataset(std::shared_ptr<const CloudSource> source,
                                            const std::string& sensor) {
  return std::make_unique<CloudDataset>(std::move(source), sensor);
}

}  // namespace mapless
