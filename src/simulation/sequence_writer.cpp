#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <system_error>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include "io/files/text.hpp"
#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include "io/formats/native/native_writer.hpp"
#include "simulation/object_states.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

void require_new(const fs::path& folder) {
  if (!fs::exists(folder)) return;
  throw OutputError({folder.string(), "", "", "exists already", "choose a new folder, or remove it"});
}

std::string object_table(const WorldDescription& world) {
  std::string rows = "object_id,class,kind\n";
  std::vector<std::pair<int, std::string>> objects;
  for (const StaticObject& s : world.statics)
    if (s.object_id > 0)
      objects.emplace_back(s.object_id, fmt::format("{},parked", to_string(s.object_class)));
  for (const Mover& m : world.movers)
    objects.emplace_back(
        m.object_id, fmt::format("{},{}", to_string(m.object_class), m.carries_sensor ? "carrier" : "mover"));
  std::sort(objects.begin(), objects.end());
  for (const auto& [id, text] : objects) rows += fmt::format("{},{}\n", id, text);
  return rows;
}

class NativeSequence final : public SequenceWriter {
 public:
  NativeSequence(const fs::path& folder, const LidarModel& model, std::vector<TimedPose> poses)
      : writer_(folder, model), poses_(std::move(poses)) {}
  void add(const SimulatedScan& scan) override {
    writer_.add_scan(scan.start, scan.records, scan.labels, scan.intensities);
  }
  void finish() override { writer_.finish(poses_); }

 private:
  NativeWriter writer_;
  std::vector<TimedPose> poses_;
};

// A laser in the terms of the format's formula, which has no origin along the beam: `along_m` is added to the
// ranges.
struct MdlidarRow {
  MdlidarLaser laser;
  double along_m;
};

MdlidarRow mdlidar_row(const Laser& laser) {
  const Vector3d origin = rotation_z(-laser.azimuth_offset_rad) * laser.origin_h_m;
  const double c = std::cos(laser.elevation_rad);
  const double s = std::sin(laser.elevation_rad);
  return {{origin.y(), -origin.x() * s + origin.z() * c, laser.azimuth_offset_rad, laser.elevation_rad},
          origin.x() * c + origin.z() * s};
}

class MdlidarSequence final : public SequenceWriter {
 public:
  MdlidarSequence(const fs::path& folder, std::shared_ptr<const LidarModel> model,
                  std::vector<TimedPose> poses)
      : model_(std::move(model)),
        trajectory_(std::move(poses), Duration(), "simulation"),
        writer_(folder, rows(*model_), model_->columns,
                Duration::from_seconds(1 / model_->rotation_rate_hz)) {}

  void add(const SimulatedScan& scan) override {
    MdlidarFrame frame;
    frame.start = scan.start;
    const auto period = Duration::from_seconds(1 / model_->rotation_rate_hz / model_->columns);
    frame.end = scan.start + Duration::from_nanoseconds((model_->columns - 1) * period.nanoseconds());
    frame.pose_p = trajectory_.at(frame.start).T_v0.inverse();
    frame.pose = trajectory_.at(frame.end).T_v0.inverse();
    frame.points.reserve(scan.records.size());
    for (std::size_t i = 0; i < scan.records.size(); ++i) {
      const LidarRecord& r = scan.records[i];
      MdlidarPoint point;
      point.rotation_deg = static_cast<float>(-model_->hub_angle(r.column) * 180 / std::numbers::pi);
      if (r.code == ReturnCode::hit) {
        const Laser& laser = model_->lasers[static_cast<std::size_t>(r.laser)];
        const double range = (r.position_v.cast<double>() - model_->point_v(r.laser, r.column, 0)).norm();
        point.range_m = static_cast<float>(range + mdlidar_row(laser).along_m);
        point.object_id = static_cast<std::int32_t>(scan.labels[i] >> 16);
        point.dynamic = (scan.labels[i] & 0xFFFF) == kLabelDynamic;
      }
      frame.points.push_back(point);
    }
    writer_.write(frame);
  }
  void finish() override { writer_.finish(); }

 private:
  static std::vector<MdlidarLaser> rows(const LidarModel& model) {
    std::vector<MdlidarLaser> out;
    for (const Laser& laser : model.lasers) out.push_back(mdlidar_row(laser).laser);
    return out;
  }
  std::shared_ptr<const LidarModel> model_;
  SampledTrajectory trajectory_;
  MdlidarWriter writer_;
};

class KittiSequence final : public SequenceWriter {
 public:
  KittiSequence(fs::path folder, std::shared_ptr<const LidarModel> model, std::vector<TimedPose> poses)
      : folder_(std::move(folder)),
        model_(std::move(model)),
        trajectory_(std::move(poses), Duration(), "simulation") {
    for (const char* name : {"velodyne", "labels"}) {
      std::error_code error;
      fs::create_directories(folder_ / name, error);
      if (error)
        throw_write_error({(folder_ / name).string(), "", "", error.message(), "choose another folder"},
                          error);
    }
    std::string calibration;
    for (const char* name : {"P0", "P1", "P2", "P3", "Tr"})
      calibration += fmt::format("{}: 1 0 0 0 0 1 0 0 0 0 1 0\n", name);
    write_file_atomically(folder_ / "calib.txt", calibration);
  }

  void add(const SimulatedScan& scan) override {
    const Time middle = scan.start + Duration::from_seconds(0.5 / model_->rotation_rate_hz);
    const SE3 T_m0 = trajectory_.at(middle).T_v0;
    std::string bytes;
    std::vector<std::uint32_t> labels;
    // Ring after ring from the highest down, each by increasing azimuth.
    for (auto l = static_cast<int>(model_->lasers.size()); l-- > 0;)
      append_ring(scan, l, T_m0, bytes, labels);
    const std::string name = fmt::format("{:06}", poses_.size());
    write_label_file(folder_ / "labels" / (name + ".label"), labels);
    write_file_atomically(folder_ / "velodyne" / (name + ".bin"), bytes);
    poses_.push_back({middle, T_m0});
  }

  void finish() override {
    std::string times;
    for (const TimedPose& pose : poses_) times += decimal_seconds(pose.time) + "\n";
    write_kitti_poses(folder_ / "poses.txt", poses_);
    write_file_atomically(folder_ / "times.txt", times);
  }

 private:
  struct KittiPoint {
    double azimuth;
    std::array<float, 4> xyzi;
    std::uint32_t label;
  };

  void append_ring(const SimulatedScan& scan, int laser, const SE3& T_m0, std::string& bytes,
                   std::vector<std::uint32_t>& labels) const {
    std::vector<KittiPoint> ring;
    for (int column = 0; column < model_->columns; ++column) {
      const auto i = static_cast<std::size_t>(laser) * static_cast<std::size_t>(model_->columns) +
                     static_cast<std::size_t>(column);
      const LidarRecord& r = scan.records[i];
      if (r.code != ReturnCode::hit) continue;
      const SE3 T_mv =
          T_m0 * trajectory_.at(scan.start + Duration::from_nanoseconds(r.time_ns)).T_v0.inverse();
      const Eigen::Vector3f p = (T_mv * r.position_v.cast<double>()).cast<float>();
      const double azimuth = std::atan2(r.position_v.y(), r.position_v.x());
      ring.push_back({azimuth < 0 ? azimuth + 2 * std::numbers::pi : azimuth,
                      {p.x(), p.y(), p.z(), scan.intensities[i]},
                      scan.labels[i]});
    }
    std::stable_sort(ring.begin(), ring.end(),
                     [](const KittiPoint& a, const KittiPoint& b) { return a.azimuth < b.azimuth; });
    for (const KittiPoint& point : ring) {
      char raw[sizeof(point.xyzi)];
      std::memcpy(raw, point.xyzi.data(), sizeof(raw));
      bytes.append(raw, sizeof(raw));
      labels.push_back(point.label);
    }
  }

  fs::path folder_;
  std::shared_ptr<const LidarModel> model_;
  SampledTrajectory trajectory_;
  std::vector<TimedPose> poses_;
};

// Adds the tables of objects to the recording of another writer.
class ObjectTablesSequence final : public SequenceWriter {
 public:
  ObjectTablesSequence(std::unique_ptr<SequenceWriter> sequence, const fs::path& folder,
                       double rotation_rate_hz, const Scene& scene)
      : sequence_(std::move(sequence)),
        half_turn_(Duration::from_seconds(0.5 / rotation_rate_hz)),
        states_(scene),
        table_(folder / "object_states.csv") {
    write_file_atomically(folder / "objects.csv", object_table(scene.world));
  }
  void add(const SimulatedScan& scan) override {
    sequence_->add(scan);
    table_.add(scans_++, states_.of_visible(scan, scan.start + half_turn_));
  }
  void finish() override { sequence_->finish(); }

 private:
  std::unique_ptr<SequenceWriter> sequence_;
  Duration half_turn_;
  ObjectStates states_;
  ObjectStatesWriter table_;
  std::size_t scans_ = 0;
};

}  // namespace

const std::vector<std::string>& sequence_formats() {
  static const std::vector<std::string> formats = {"native", "mdlidar", "kitti"};
  return formats;
}

LidarModel model_for_format(LidarModel model, std::string_view format) {
  if (format == "mdlidar") {
    for (Laser& laser : model.lasers) laser.firing_offset = Duration();
  }
  // In bare clouds only the azimuth gives the time of a point. The turn starts at the rear, as in the KITTI
  // dataset.
  if (format == "kitti") model.start_azimuth_rad = std::numbers::pi;
  return model;
}

std::unique_ptr<SequenceWriter> make_sequence_writer(std::string_view format, const fs::path& folder,
                                                     std::shared_ptr<const LidarModel> model,
                                                     const Scene& scene) {
  require_given("make_sequence_writer", "model", model.get());
  validate(*model, "make_sequence_writer");
  require_new(folder);
  const double rate_hz = model->rotation_rate_hz;
  std::unique_ptr<SequenceWriter> writer;
  if (format == "native") {
    writer = std::make_unique<NativeSequence>(folder, *model, scene.poses_in_world());
  } else if (format == "mdlidar") {
    writer = std::make_unique<MdlidarSequence>(folder, std::move(model), scene.poses_in_world());
  } else if (format == "kitti") {
    writer = std::make_unique<KittiSequence>(folder, std::move(model), scene.poses_in_world());
  } else {
    throw ParameterError({"format", "name", std::string(format), "cannot be written",
                          fmt::format("choose one of {}", fmt::join(sequence_formats(), ", "))});
  }
  return std::make_unique<ObjectTablesSequence>(std::move(writer), folder, rate_hz, scene);
}

}  // namespace mapless
