#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

#include "core/parallel_parts.hpp"
#include <mapless/live/live_output.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::uint8_t kUint8 = 2;  // PointField.datatype
constexpr std::uint8_t kUint32 = 6;
constexpr std::uint8_t kFloat32 = 7;
constexpr std::uint32_t kAlignment = 4;
constexpr std::string_view kObjectId = "object_id", kMoving = "moving", kProbability = "probability";
// Chosen: 50 Hz at 10 turns a second, as wheel odometry is usually published.
constexpr int kPosesPerScan = 5;

// Calls visit(index of the point, its first byte) for the points from `begin` to before `end`.
template <class Visit>
void for_each_point(const PointCloud2View& cloud, std::size_t begin, std::size_t end, Visit&& visit) {
  if (begin == end) return;
  std::size_t row = begin / cloud.width, column = begin % cloud.width;
  for (std::size_t i = begin; i < end; ++i) {
    visit(i, cloud.data.data() + row * cloud.row_step + column * cloud.point_step);
    if (++column < cloud.width) continue;
    column = 0;
    ++row;
  }
}

PointCloud2 cloud_of(PointCloud2View view, std::shared_ptr<std::uint8_t[]> bytes) {
  view.row_step = view.width * view.point_step;
  view.data = {bytes.get(), view.size() * view.point_step};
  return {std::move(view), std::move(bytes)};
}

void write_word(std::uint32_t word, bool is_bigendian, std::uint8_t* at) {
  for (int byte = 0; byte < 4; ++byte)
    at[is_bigendian ? 3 - byte : byte] = static_cast<std::uint8_t>(word >> (8 * byte));
}

// 0 for static points, and for objects without a track.
std::vector<std::uint32_t> ids_by_number(const Detection& detection) {
  std::uint16_t largest = 0;
  for (const std::uint16_t number : detection.object) largest = std::max(largest, number);
  std::vector<std::uint32_t> ids(std::size_t{largest} + 1, 0);
  for (const TrackedObject& object : detection.tracked) {
    if (object.number <= largest) ids[static_cast<std::size_t>(object.number)] = object.id;
  }
  return ids;
}

bool has_odometry(const LiveOutput& output) {
  const auto& update = output.labelled.odometry;
  return update && !update->knots.empty() && update->state != MotionState::lost && output.body_known;
}

}  // namespace

std::vector<PointMotion> point_motions(const LiveOutput& output) {
  const Detection& detection = output.labelled.detection;
  const LidarScan& scan = output.labelled.scan();
  std::vector<PointMotion> motions(scan.input_size, PointMotion::unknown);
  if (!detection.motion_known) return motions;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    motions[scan.returns[i].input_index] = detection.dynamic(i) ? PointMotion::moving : PointMotion::still;
  }
  return motions;
}

PointCloud2 labelled_cloud(const LiveOutput& output) {
  const PointCloud2View& in = output.cloud.view;
  PointCloud2View out = in;
  const std::uint32_t id_offset = (in.point_step + kAlignment - 1) / kAlignment * kAlignment;
  const std::uint32_t motion_offset = id_offset + 4;
  const std::uint32_t probability_offset = motion_offset + 4;
  out.point_step = probability_offset + 4;
  // A cloud that was labelled before: readers take the first field of a name.
  std::erase_if(out.fields, [](const PointCloud2Field& field) {
    return field.name == kObjectId || field.name == kMoving || field.name == kProbability;
  });
  out.fields.push_back({std::string(kObjectId), id_offset, kUint32, 1});
  out.fields.push_back({std::string(kMoving), motion_offset, kUint8, 1});
  out.fields.push_back({std::string(kProbability), probability_offset, kFloat32, 1});
  const std::vector<std::uint32_t> id_of_number = ids_by_number(output.labelled.detection);
  const std::vector<PointMotion> motions = point_motions(output);
  const std::vector<float> probabilities = output.labelled.probability_by_input();
  const std::vector<std::uint16_t> numbers = output.labelled.object_by_input();
  std::shared_ptr<std::uint8_t[]> bytes(new std::uint8_t[in.size() * out.point_step]);
  const auto write = [&](std::size_t i, const std::uint8_t* point) {
    std::uint8_t* to = bytes.get() + i * out.point_step;
    std::memcpy(to, point, in.point_step);
    write_word(std::bit_cast<std::uint32_t>(probabilities[i]), in.is_bigendian, to + probability_offset);
    write_word(id_of_number[numbers[i]], in.is_bigendian, to + id_offset);
    for (std::uint32_t at = in.point_step; at < id_offset; ++at) to[at] = 0;
    to[motion_offset] = static_cast<std::uint8_t>(motions[i]);
    for (std::uint32_t at = motion_offset + 1; at < probability_offset; ++at) to[at] = 0;
  };
  for_parts(in.size(),
            [&](std::size_t, std::size_t begin, std::size_t end) { for_each_point(in, begin, end, write); });
  return cloud_of(std::move(out), std::move(bytes));
}

PointCloud2 selected_cloud(const LiveOutput& output, PointMotion motion) {
  const PointCloud2View& in = output.cloud.view;
  const std::vector<PointMotion> motions = point_motions(output);
  const auto count = static_cast<std::size_t>(std::count(motions.begin(), motions.end(), motion));
  std::shared_ptr<std::uint8_t[]> bytes(new std::uint8_t[count * in.point_step]);
  std::uint8_t* to = bytes.get();
  for_each_point(in, 0, in.size(), [&](std::size_t i, const std::uint8_t* point) {
    if (motions[i] == motion) to = std::copy(point, point + in.point_step, to);
  });
  PointCloud2View out = in;
  out.height = 1;
  out.width = static_cast<std::uint32_t>(count);
  return cloud_of(std::move(out), std::move(bytes));
}

std::vector<LiveObject> live_objects(const LiveOutput& output) {
  const Eigen::Matrix3d& rotation = output.T_w0.rotation();
  std::vector<LiveObject> objects;
  for (const TrackedObject& tracked : output.labelled.detection.tracked) {
    LiveObject object;
    object.id = tracked.id;
    object.time = tracked.time;
    object.centre_w = output.T_w0 * tracked.centre_0;
    object.rotation_wb = rotation;
    object.extent_b = tracked.extent_0;
    object.velocity_w = rotation * tracked.velocity_0;
    object.velocity_covariance_w = rotation * tracked.velocity_covariance_0 * rotation.transpose();
    objects.push_back(object);
  }
  return objects;
}

std::vector<LivePose> live_poses(const LiveOutput& output) {
  std::vector<LivePose> poses;
  if (!has_odometry(output)) return poses;
  const LidarScan& scan = output.labelled.scan();
  for (int i = 1; i <= kPosesPerScan; ++i) {
    const Time time = scan.start + (scan.end() - scan.start) * (static_cast<double>(i) / kPosesPerScan);
    poses.push_back({time, output.T_w0 * output.labelled.trajectory->at(time).T_v0.inverse() * output.T_vb});
  }
  return poses;
}

std::vector<LiveTransform> live_transforms(const LiveOutput& output, bool inverted) {
  std::vector<LiveTransform> transforms;
  for (const LivePose& pose : live_poses(output)) {
    if (inverted) {
      transforms.push_back({pose.time, output.body_frame, output.world_frame, pose.T_wb.inverse()});
    } else {
      transforms.push_back({pose.time, output.world_frame, output.body_frame, pose.T_wb});
    }
  }
  return transforms;
}

// A perturbation xi of the sensor, exp(xi) T_v0, is Ad(T_bv) xi of the body; so is the velocity. On T_wb it
// acts from the right, as exp(-Ad xi): along the axes of w it is that, rotated.
std::optional<LiveOdometry> live_odometry(const LiveOutput& output) {
  if (!has_odometry(output)) return std::nullopt;
  const auto& update = output.labelled.odometry;
  const TrajectoryKnot& knot = update->knots.back();
  LiveOdometry odometry;
  odometry.time = knot.time;
  odometry.T_wb = output.T_w0 * knot.T_v0.inverse() * output.T_vb;
  const SE3 T_bv = output.T_vb.inverse();
  Matrix6d to_body = Matrix6d::Zero();
  to_body.topLeftCorner<3, 3>() = T_bv.rotation();
  to_body.bottomRightCorner<3, 3>() = T_bv.rotation();
  to_body.topRightCorner<3, 3>() = hat(T_bv.translation()) * T_bv.rotation();
  Matrix6d to_world = Matrix6d::Zero();
  to_world.topLeftCorner<3, 3>() = odometry.T_wb.rotation();
  to_world.bottomRightCorner<3, 3>() = odometry.T_wb.rotation();
  to_world = to_world * to_body;
  odometry.pose_covariance_w = to_world * update->covariance.topLeftCorner<6, 6>() * to_world.transpose();
  odometry.velocity_b = -(to_body * knot.varpi);
  odometry.velocity_covariance_b =
      to_body * update->covariance.bottomRightCorner<6, 6>() * to_body.transpose();
  return odometry;
}

}  // namespace mapless
