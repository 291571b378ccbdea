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
#include "lidar/model_estimation.hpp"
#include "lidar/ring_recovery.hpp"
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

// The points as measured. The instant of each follows from the azimuth at which it was measured, which the
// compensation has changed a little: a fixed-point iteration, each pass of which leaves about a hundredth of
// the error.
void take_compensation_back(Cloud& cloud, const BareCloudScan& scan, const Trajectory& trajectory) {
  constexpr int kSteps = 1024;  // poses per turn: 0.1 ms apart, in which 15 m/s are 1.5 mm
  constexpr int kPasses = 3;
  const SE3 T_0c = trajectory.at(*scan.compensated_to).T_v0.inverse();
  std::vector<SE3> T_vc;
  for (int i = 0; i < kSteps; ++i) {
    const Time t = scan.start + (scan.end - scan.start) * ((i + 0.5) / kSteps);
    T_vc.push_back(trajectory.at(t).T_v0 * T_0c);
  }
  for (Eigen::Vector3f& p : cloud) {
    if (!is_usable(p)) continue;
    const Eigen::Vector3d p_c = p.cast<double>();
    Eigen::Vector3d p_v = p_c;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double turn = (1 - std::atan2(p_v.y(), p_v.x()) / std::numbers::pi) / 2;
      p_v = T_vc[static_cast<std::size_t>(std::clamp(turn * kSteps, 0.0, kSteps - 1.0))] * p_c;
    }
    p = p_v.cast<float>();
  }
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

  // A scan that cannot be read is left out here; reading it later throws.
  [[nodiscard]] std::vector<Cloud> clouds_for_estimate() const {
    std::set<std::size_t> chosen;
    const std::size_t last = recording_.scans.size() - 1;
    for (std::size_t i = 0; i < kScansForEstimate; ++i) chosen.insert(i * last / (kScansForEstimate - 1));
    std::vector<Cloud> clouds;
    for (const std::size_t k : chosen) {
      const BareCloudScan& scan = recording_.scans[k];
      try {
        clouds.push_back(read_kitti_cloud(scan.file));
      } catch (const InputError&) {
        if (k == last && clouds.empty()) throw;
        continue;
      }
      if (scan.compensated_to && recording_.trajectory) {
        take_compensation_back(clouds.back(), scan, *recording_.trajectory);
      }
    }
    return clouds;
  }

  void estimate() {
    ModelEstimationOptions options;
    options.name = "estimated from the points";
    options.rotation_rate_hz = 1 / median_duration_s(recording_.scans);
    options.start_azimuth_rad = kSeam_rad;
    EstimatedModel estimated = estimate_model(clouds_for_estimate(), options, recording_.folder.string());
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
