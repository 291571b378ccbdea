#include "io/formats/mdlidar/mdlidar_writer.hpp"

#include <system_error>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include "mdlidar.pb.h"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

void set(const Eigen::Vector3d& from, mdlidar::Vector3D& to) {
  to.set_x(static_cast<float>(from.x()));
  to.set_y(static_cast<float>(from.y()));
  to.set_z(static_cast<float>(from.z()));
}

void set(const Eigen::Matrix3d& rotation, mdlidar::Orientation& to) {
  const Eigen::Vector3d phi = so3_log(rotation);
  const double angle = phi.norm();
  set(angle > 0 ? Eigen::Vector3d(phi / angle) : Eigen::Vector3d::UnitZ(), *to.mutable_axis());
  to.set_angle(static_cast<float>(angle));
}

std::string message_bytes(const google::protobuf::MessageLite& message, const std::filesystem::path& file) {
  std::string bytes;
  if (!message.SerializeToString(&bytes)) {
    throw OutputError({file.string(), "size", std::to_string(message.ByteSizeLong()),
                       "too large for one message", "write fewer points"});
  }
  return bytes;
}

}  // namespace

MdlidarWriter::MdlidarWriter(std::filesystem::path folder, const std::vector<MdlidarLaser>& lasers,
                             int points_per_laser, Duration frame_period)
    : folder_(std::move(folder)),
      lasers_(lasers.size()),
      points_per_laser_(points_per_laser),
      frame_period_(frame_period) {
  constexpr double kMost = 1e6;  // as of a LidarModel
  require_between("MdlidarWriter", "lasers.size()", static_cast<double>(lasers.size()), 1, kMost);
  require_between("MdlidarWriter", "points_per_laser", points_per_laser, 2, kMost);
  require_between("MdlidarWriter", "frame_period [s]", frame_period.seconds(), 1e-9, Duration::kMaxSeconds);
  std::error_code error;
  std::filesystem::create_directories(folder_ / "frame", error);
  if (error)
    throw_write_error({(folder_ / "frame").string(), "", "", error.message(), "choose another folder"},
                      error);
  std::string rows;
  for (const MdlidarLaser& l : lasers) {
    rows += fmt::format("{},{},{},{}\n", l.horiz_offset_m, l.vert_offset_m, l.rot_correction_rad,
                        l.vert_correction_rad);
  }
  write_file_atomically(folder_ / "vel_64_calib.csv", rows);
}

void MdlidarWriter::write(const MdlidarFrame& frame) {
  const std::filesystem::path file = folder_ / "frame" / fmt::format("data_{}", frames_);
  if (frame.points.size() != points_per_frame()) {
    throw InputError({file.string(), "points", std::to_string(frame.points.size()),
                      fmt::format("a frame has {}", points_per_frame()),
                      "give one for every laser and column"});
  }
  mdlidar::Frame message;
  message.set_start_time(frame.start.nanoseconds());
  message.set_end_time(frame.end.nanoseconds());
  message.mutable_points()->Reserve(static_cast<int>(frame.points.size()));
  for (const MdlidarPoint& p : frame.points) {
    mdlidar::Point& point = *message.add_points();
    point.set_range(p.range_m);
    point.set_rotation(p.rotation_deg);
    point.set_object_id(p.object_id);
    point.set_dynamic(p.dynamic);
  }
  mdlidar::State& state = *message.mutable_state();
  set(frame.pose.translation(), *state.mutable_position());
  set(frame.pose.rotation(), *state.mutable_orientation());
  set(frame.pose_p.translation(), *state.mutable_position_p());
  set(frame.pose_p.rotation(), *state.mutable_orientation_p());
  write_file_atomically(file, message_bytes(message, file));
  ++frames_;
}

void MdlidarWriter::finish() const {
  mdlidar::Header header;
  header.set_delta_time(static_cast<float>(frame_period_.seconds()));
  header.set_channels_count(static_cast<int>(lasers_));
  header.set_points_count_by_channel(static_cast<std::uint32_t>(points_per_laser_));
  write_file_atomically(folder_ / "header", message_bytes(header, folder_ / "header"));
}

}  // namespace mapless
