#include "io/formats/mdlidar/mdlidar_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "io/files/numbered_files.hpp"
#include "io/formats/mdlidar/mdlidar_files.hpp"
#include "io/formats/mdlidar/pose_reading.hpp"
#include "mdlidar.pb.h"
#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMaxRange_m = 120;  // of the dataset's sensor (paper, section V)

std::map<int, fs::path> frame_files(const fs::path& folder) {
  std::map<int, fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder / "frame", error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::string digits = name.rfind("data_", 0) == 0 ? name.substr(5) : "";
    const bool number =
        !digits.empty() && digits.size() < 10 && digits.find_first_not_of("0123456789") == std::string::npos;
    if (number) files.emplace(std::stoi(digits), it->path());
  }
  return files;
}

fs::path calibration_file(const fs::path& folder) {
  const fs::path name = "vel_64_calib.csv";
  for (const fs::path& file : {folder / name, folder / ".." / name}) {
    if (fs::exists(file)) return file;
  }
  throw InputError({(folder / name).string(), "", "", "missing, and not one folder up either",
                    "put the dataset's vel_64_calib.csv beside the header"});
}

// A laser as method.md section 4 places its points: origin Rz(rot) (-v sin vert, h, v cos vert).
Laser laser_of(const MdlidarLaser& row) {
  Laser laser;
  laser.elevation_rad = row.vert_correction_rad;
  laser.azimuth_offset_rad = row.rot_correction_rad;
  const Eigen::Vector3d origin(-row.vert_offset_m * std::sin(row.vert_correction_rad), row.horiz_offset_m,
                               row.vert_offset_m * std::cos(row.vert_correction_rad));
  laser.origin_h_m = rotation_z(row.rot_correction_rad) * origin;
  return laser;
}

Eigen::Vector3d position_of(const MdlidarLaser& l, double range, double rotation_deg) {
  const double a = rotation_deg * kDegree - l.rot_correction_rad;
  const double xy =
      range * std::cos(l.vert_correction_rad) - l.vert_offset_m * std::sin(l.vert_correction_rad);
  return {xy * std::cos(a) + l.horiz_offset_m * std::sin(a),
          -xy * std::sin(a) + l.horiz_offset_m * std::cos(a),
          range * std::sin(l.vert_correction_rad) + l.vert_offset_m * std::cos(l.vert_correction_rad)};
}

std::uint32_t label_of(const MdlidarPoint& point) {
  if (!(point.range_m >= 0)) return kLabelUnknown;
  const std::uint32_t label = point.dynamic ? kLabelDynamic : kLabelStatic;
  return label | (static_cast<std::uint32_t>(point.object_id) << 16);
}

class MdlidarDataset final : public Dataset {
 public:
  MdlidarDataset(const fs::path& folder, const DatasetOptions& options)
      : calibration_(read_mdlidar_calibration(calibration_file(folder))) {
    const std::map<int, fs::path> files = frame_files(folder);
    if (files.empty()) {
      throw InputError(
          {(folder / "frame").string(), "frames", "0", "no data_<i> files", "give a folder town_N"});
    }
    const mdlidar::Header header = read_mdlidar_header(folder / "header");
    columns_ = static_cast<int>(header.points_count_by_channel());
    if (static_cast<std::size_t>(header.channels_count()) != calibration_.size()) {
      throw InputError({(folder / "header").string(), "channels_count",
                        std::to_string(header.channels_count()),
                        fmt::format("vel_64_calib.csv has {} lasers", calibration_.size()),
                        "use the calibration of this recording"});
    }
    for (const auto& [number, file] : files) files_.push_back(file);
    read_summaries();
    model_ = make_model();
    read_trajectory(folder, options);
    if (const std::string gaps = missing_numbers(files); !gaps.empty())
      notes_.push_back("frames missing: " + gaps);
    find_labels(files, options.labels);
  }

  [[nodiscard]] std::string format() const override { return "mdlidar"; }
  [[nodiscard]] std::size_t size() const override { return files_.size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return model_; }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return frames_[checked(k)].start; }
  [[nodiscard]] Time scan_end(std::size_t k) const override {
    return scan_start(k) + Duration::from_nanoseconds(column_period(k).nanoseconds() * columns_);
  }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return files_[checked(k)]; }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override {
    if (poses_.refusal) throw InputError(*poses_.refusal);
    return poses_.trajectory;
  }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }

  [[nodiscard]] LidarScan read(std::size_t k) const override {
    LidarScan scan;
    scan.model = model_;
    scan.start = scan_start(k);
    scan.columns = columns_;
    scan.column_period = column_period(k);
    scan.time_source = Provenance::sensor;
    scan.ring_source = Provenance::sensor;
    std::vector<LidarRecord> records(points_of(k));
    const auto length_ns = static_cast<double>((frames_[k].end - frames_[k].start).nanoseconds());
    read_mdlidar_points(files_[k], records.size(), [&](std::size_t i, const MdlidarPoint& point) {
      const std::size_t channel = i / static_cast<std::size_t>(columns_);
      const auto column = static_cast<int>(i % static_cast<std::size_t>(columns_));
      require_rotation(point.rotation_deg, channel, column, k);
      const bool hit = point.range_m >= 0;
      records[i] = {position_of(calibration_[channel], point.range_m, point.rotation_deg).cast<float>(),
                    row_of_channel_[channel], column,
                    static_cast<std::int32_t>(std::lround(column * length_ns / (columns_ - 1))),
                    hit ? ReturnCode::hit : ReturnCode::faulty};
    });
    return organise(std::move(scan), records, files_[k].string());
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    if (!label_files_.empty()) {
      if (label_files_[checked(k)].empty()) return std::nullopt;
      return read_label_file(label_files_[k], points_per_frame());
    }
    std::vector<std::uint32_t> labels(points_of(checked(k)));
    read_mdlidar_points(files_[k], labels.size(),
                        [&](std::size_t i, const MdlidarPoint& point) { labels[i] = label_of(point); });
    return labels;
  }

 private:
  [[nodiscard]] std::size_t points_per_frame() const {
    return calibration_.size() * static_cast<std::size_t>(columns_);
  }

  // Memory is taken for as many points as the file holds, whatever the header says.
  [[nodiscard]] std::size_t points_of(std::size_t k) const {
    require_mdlidar_points(files_[k], frames_[k].points, points_per_frame());
    return frames_[k].points;
  }

  [[nodiscard]] Duration column_period(std::size_t k) const {
    return Duration::from_nanoseconds((frames_[checked(k)].end - frames_[checked(k)].start).nanoseconds() /
                                      (columns_ - 1));
  }

  // A frame's own column 0 may point anywhere, as long as it is where the first frame's does.
  void require_rotation(float rotation_deg, std::size_t channel, int column, std::size_t k) const {
    const double off =
        std::remainder(-rotation_deg * kDegree - model_->hub_angle(column), 2 * std::numbers::pi);
    if (std::abs(off) <= 2 * std::numbers::pi / model_->columns) return;
    throw InputError({files_[k].string(), fmt::format("rotation of channel {} point {}", channel, column),
                      fmt::format("{} degrees", rotation_deg),
                      fmt::format("more than a column from {:.3f}, where the first frame has this point",
                                  -model_->hub_angle(column) / kDegree),
                      "the points must be laser after laser, each in firing order"});
  }

  void read_summaries() {
    frames_.resize(files_.size());
    tbb::parallel_for(std::size_t{0}, files_.size(),
                      [&](std::size_t k) { frames_[k] = read_mdlidar_summary(files_[k]); });
  }

  // Rotations of the first frame's first laser give start and step of the columns.
  std::shared_ptr<const LidarModel> make_model() {
    std::vector<float> rotations_deg(static_cast<std::size_t>(columns_));
    read_mdlidar_points(files_.front(), points_per_frame(), [&](std::size_t i, const MdlidarPoint& point) {
      if (i < rotations_deg.size()) rotations_deg[i] = point.rotation_deg;
    });
    double turned_deg = 0;
    for (std::size_t c = 1; c < rotations_deg.size(); ++c) {
      turned_deg += std::remainder(rotations_deg[c] - rotations_deg[c - 1], 360.0F);
    }
    if (!(turned_deg > 180 && turned_deg < 540)) {
      throw InputError({files_.front().string(), "rotation",
                        fmt::format("{} degrees from first to last", turned_deg), "not a clockwise turn",
                        "the points must be laser after laser, each in firing order"});
    }
    LidarModel model;
    model.name = "mdlidar";
    model.columns = static_cast<int>(std::lround(360 * (columns_ - 1) / turned_deg));
    model.direction = SpinDirection::clockwise;
    model.start_azimuth_rad = -rotations_deg.front() * kDegree;
    model.rotation_rate_hz = turned_deg / 360 / (frames_.front().end - frames_.front().start).seconds();
    model.max_range_m = kMaxRange_m;
    std::vector<std::size_t> order(calibration_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return calibration_[a].vert_correction_rad < calibration_[b].vert_correction_rad;
    });
    row_of_channel_.resize(order.size());
    for (std::size_t row = 0; row < order.size(); ++row) {
      row_of_channel_[order[row]] = static_cast<std::int32_t>(row);
      model.lasers.push_back(laser_of(calibration_[order[row]]));
    }
    validate(model, files_.front().string());
    notes_.emplace_back("returns: range -1 is taken as faulty (why nothing came back is not recorded)");
    return std::make_shared<const LidarModel>(std::move(model));
  }

  void read_trajectory(const fs::path& folder, const DatasetOptions& options) {
    const auto readable = [this](std::size_t k) -> std::shared_ptr<const LidarScan> {
      try {
        return std::make_shared<const LidarScan>(read(k));
      } catch (const InputError&) {  // read() of this scan throws it again
        return nullptr;
      }
    };
    poses_ = choose_pose_reading(frames_, options.pose_direction, options.pose_instant,
                                 (folder / "frame").string(), readable);
    notes_.insert(notes_.end(), poses_.notes.begin(), poses_.notes.end());
  }

  void find_labels(const std::map<int, fs::path>& files, const fs::path& folder) {
    if (folder.empty()) return;
    const auto labels = numbered_files(folder, ".label");
    std::size_t found = 0;
    for (const auto& [number, file] : files) {
      const auto it = labels.find(number);
      label_files_.push_back(it == labels.end() ? fs::path() : it->second);
      found += it == labels.end() ? 0 : 1;
    }
    notes_.push_back(fmt::format("labels: {} of {} scans, from {}", found, files.size(), folder.string()));
  }

  std::vector<MdlidarLaser> calibration_;
  int columns_ = 0;
  std::vector<fs::path> files_;
  std::vector<MdlidarFrameSummary> frames_;
  std::vector<std::int32_t> row_of_channel_;
  std::shared_ptr<const LidarModel> model_;
  PoseReadingChoice poses_;
  std::vector<fs::path> label_files_;
  std::vector<std::string> notes_;
};

}  // namespace

bool looks_mdlidar(const fs::path& path) {
  return fs::is_regular_file(path / "header") && fs::is_directory(path / "frame");
}

std::unique_ptr<Dataset> open_mdlidar(const fs::path& path, const DatasetOptions& options) {
  if (!options.sensor.empty()) {
    throw ParameterError({"--sensor", "", options.sensor, "an mdlidar recording has its own calibration",
                          "leave it out; replace vel_64_calib.csv for another one"});
  }
  if (!looks_mdlidar(path)) {
    throw InputError({path.string(), "", "", "no file header and folder frame", "give a folder town_N"});
  }
  return std::make_unique<MdlidarDataset>(path, options);
}

}  // namespace mapless
