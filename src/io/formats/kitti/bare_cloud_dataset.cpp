#include "io/formats/kitti/bare_cloud_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/median.hpp"
#include "io/files/numbered_files.hpp"
#include "io/formats/kitti/kitti_files.hpp"
#include "lidar/recovery/firing_offsets.hpp"
#include "lidar/recovery/model_estimation.hpp"
#include "lidar/recovery/ring_recovery.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;
using Cloud = std::vector<Eigen::Vector3f>;

// Scans the sensor is estimated from, evenly spread over the recording. Chosen: an estimate from five clouds
// of 120,000 points is limited by the rounding of the clouds to a millimetre, not by their number.
constexpr std::size_t kScansForEstimate = 5;
constexpr double kSeam_rad = std::numbers::pi;

double median_duration_s(const std::vector<BareCloudScan>& scans) {
  std::vector<double> durations;
  for (const BareCloudScan& scan : scans) durations.push_back((scan.end - scan.start).seconds());
  return median(std::move(durations));
}

// The sensor during the turn, from the frame of the compensated points.
std::vector<SE3> motion_of_turn(const BareCloudScan& scan, const Trajectory& trajectory) {
  constexpr int kSteps = 1024;  // 0.1 ms apart, in which 15 m/s are 1.5 mm
  const SE3 T_0c = trajectory.at(*scan.compensated_to).T_v0.inverse();
  std::vector<SE3> T_vc;
  for (int i = 0; i < kSteps; ++i) {
    const Time t = scan.start + (scan.end - scan.start) * ((i + 0.5) / kSteps);
    T_vc.push_back(trajectory.at(t).T_v0 * T_0c);
  }
  return T_vc;
}

class BareCloudDataset final : public Dataset {
 public:
  BareCloudDataset(BareCloudRecording recording, const DatasetOptions& options)
      : recording_(std::move(recording)), notes_(recording_.notes) {
    if (options.sensor.empty()) {
      estimate();
    } else {
      take_named(options.sensor);
    }
  }

  [[nodiscard]] std::string format() const override { return recording_.format; }
  [[nodiscard]] std::size_t size() const override { return recording_.scans.size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return model_; }
  [[nodiscard]] std::optional<ModelEstimate> model_estimate() const override { return estimate_; }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return recording_.scans[checked(k)].start; }
  [[nodiscard]] Time scan_end(std::size_t k) const override { return recording_.scans[checked(k)].end; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return recording_.scans[checked(k)].file; }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override {
    return recording_.trajectory;
  }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    const BareCloudScan& from = recording_.scans[checked(k)];
    const Cloud cloud = read_kitti_cloud(from.file);
    LidarScan scan;
    scan.model = model_;
    scan.start = from.start;
    scan.columns = model_->columns;
    const Duration duration = from.end - from.start;
    scan.column_period = Duration::from_nanoseconds(duration.nanoseconds() / scan.columns);
    scan.time_source = Provenance::recovered_from_angle;
    scan.ring_source = Provenance::recovered_from_order;
    scan.compensated_to = from.compensated_to;
    // The azimuths of a compensated cloud no longer lie on the grid of the encoder.
    BareCloudLayout layout = layout_;
    if (from.compensated_to) layout.encoder_steps = 0;
    return organise(std::move(scan), recover_records(cloud, *model_, layout, duration, from.file.string()),
                    from.file.string());
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    const BareCloudScan& from = recording_.scans[checked(k)];
    if (!from.labels) return std::nullopt;
    return read_label_file(*from.labels, read_kitti_cloud(from.file).size());
  }

 private:
  void take_named(const std::string& sensor) {
    LidarModel model = model_from_name_or_file(sensor);
    model.start_azimuth_rad = kSeam_rad;
    model.direction = SpinDirection::clockwise;
    model.rotation_rate_hz = 1 / median_duration_s(recording_.scans);
    notes_.push_back(
        fmt::format("sensor: {}, its lasers matched to the stored rings from the top down", model.name));
    layout_ = top_first_layout(model);
    model_ = std::make_shared<const LidarModel>(std::move(model));
  }

  struct Sample {
    std::vector<std::size_t> scans;
    std::vector<Cloud> clouds;
  };
  // A scan that cannot be read is left out here; reading it later throws.
  [[nodiscard]] Sample clouds_for_estimate() const {
    std::set<std::size_t> chosen;
    const std::size_t last = recording_.scans.size() - 1;
    for (std::size_t i = 0; i < kScansForEstimate; ++i) chosen.insert(i * last / (kScansForEstimate - 1));
    Sample out;
    for (const std::size_t k : chosen) {
      try {
        out.clouds.push_back(read_kitti_cloud(recording_.scans[k].file));
        out.scans.push_back(k);
      } catch (const InputError&) {
        if (k == last && out.clouds.empty()) throw;
      }
    }
    return out;
  }

  // Compensated clouds: taken back by the azimuths of the points, as KITTI has compensated them; where that
  // does not bring them to the encoder's grid, by the instants of the firings.
  [[nodiscard]] EstimatedModel estimated_by(ModelEstimationOptions options) const {
    const Sample sample = clouds_for_estimate();
    const std::string source = recording_.folder.string();
    if (!recording_.trajectory || !recording_.scans.front().compensated_to)
      return estimate_model(sample.clouds, options, source);
    RingedClouds rings = find_rings(sample.clouds, options.expected_rings, source);
    std::vector<CompensatedCloud> compensated;
    for (std::size_t i = 0; i < rings.clouds.size(); ++i) {
      const BareCloudScan& scan = recording_.scans[sample.scans[rings.numbers[i]]];
      compensated.push_back({std::move(rings.clouds[i]), motion_of_turn(scan, *recording_.trajectory)});
    }
    const auto estimated = [&](const std::vector<double>& offsets_rad) {
      std::vector<RingedCloud> measured;
      for (const CompensatedCloud& cloud : compensated)
        measured.push_back({measured_points(cloud, offsets_rad), cloud.cloud.rings});
      return estimate_model_of_rings(measured, rings.ring_count, options, source);
    };
    EstimatedModel by_azimuth = estimated(std::vector<double>(rings.ring_count, 0));
    if (by_azimuth.estimate.encoder_steps > 0) return by_azimuth;
    const auto offsets_rad = find_firing_offsets(compensated, rings.ring_count);
    if (!offsets_rad) return by_azimuth;
    options.offsets_near_rad = *offsets_rad;
    return estimated(*offsets_rad);
  }

  void estimate() {
    ModelEstimationOptions options;
    options.name = "estimated from the points";
    options.rotation_rate_hz = 1 / median_duration_s(recording_.scans);
    options.start_azimuth_rad = kSeam_rad;
    EstimatedModel estimated = estimated_by(options);
    const ModelEstimate& e = estimated.estimate;
    notes_.push_back(fmt::format(
        "sensor: {} lasers and their elevations and vertical origins estimated from {} scans, to {:.2f} mm "
        "RMS{}; "
        "maximum range 120 m, as of an HDL-64E",
        estimated.model.lasers.size(), e.scans_used, 1000 * e.elevation_residual_m,
        e.lasers_borrowed == 0 ? ""
                               : fmt::format(", {} of them borrowed from neighbours", e.lasers_borrowed)));
    notes_.push_back(azimuth_note(e, estimated.model));
    layout_ = estimated.layout;
    estimate_ = e;
    model_ = std::make_shared<const LidarModel>(std::move(estimated.model));
  }

  static std::string azimuth_note(const ModelEstimate& e, const LidarModel& model) {
    if (e.encoder_steps == 0) {
      return fmt::format("azimuths: no grid found; {} columns from the mean step, azimuth offsets taken as 0",
                         model.columns);
    }
    return fmt::format(
        "azimuths: a grid of {} positions in a turn, {} columns; {} of {} lasers placed on it{}",
        e.encoder_steps, model.columns, e.azimuths_known, model.lasers.size(),
        e.azimuths_absolute ? ", with their whole azimuth offset and horizontal origin"
                            : ", to less than a column");
  }

  BareCloudRecording recording_;
  std::vector<std::string> notes_;
  std::shared_ptr<const LidarModel> model_;
  BareCloudLayout layout_;
  std::optional<ModelEstimate> estimate_;
};

}  // namespace

std::unique_ptr<Dataset> make_bare_cloud_dataset(BareCloudRecording recording,
                                                 const DatasetOptions& options) {
  return std::make_unique<BareCloudDataset>(std::move(recording), options);
}

void find_label_files(BareCloudRecording& recording, const std::vector<int>& numbers, const fs::path& own,
                      const DatasetOptions& options) {
  const bool named = !options.labels.empty();
  const fs::path folder = named ? options.labels : own;
  if (!named && !fs::is_directory(folder)) return;
  const auto files = numbered_files(folder, ".label");
  std::size_t found = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto it = files.find(numbers[k]);
    if (it == files.end()) continue;
    recording.scans[k].labels = it->second;
    ++found;
  }
  if (named && found == 0) {
    throw InputError({folder.string(), "labels", "none", "no NNNNNN.label with the number of a scan",
                      "give the folder that has the recording's label files"});
  }
  recording.notes.push_back(
      fmt::format("labels: {} of {} scans, from {}", found, numbers.size(), folder.string()));
}

}  // namespace mapless
