#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "core/rotation_check.hpp"
#include "io/files/text.hpp"
#include "io/tables/pose_numbers.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kTumNumbers = 8;
constexpr std::size_t kKittiNumbers = 12;
// One row of the file and its position, for messages.
struct Row {
  std::string where;  // file:line
  std::string field;  // "pose row 17", from 0, as scans are counted
  std::vector<std::string_view> words;

  [[noreturn]] void refuse(const std::string& part, std::string value, std::string problem,
                           std::string remedy) const {
    throw InputError({where, field + part, std::move(value), std::move(problem), std::move(remedy)});
  }
  [[nodiscard]] double number(std::size_t i) const {
    const std::optional<double> number = parse_double(words[i]);
    const std::string part = fmt::format(", number {}", i + 1);
    if (!number)
      refuse(part, std::string(words[i]), "is not a number", "mend the row, or start a comment with #");
    if (!std::isfinite(*number)) refuse(part, std::string(words[i]), "is not finite", "leave the row out");
    return *number;
  }
  [[nodiscard]] std::string text(std::size_t first, std::size_t count) const {
    return fmt::format("{}", fmt::join(words.begin() + static_cast<std::ptrdiff_t>(first),
                                       words.begin() + static_cast<std::ptrdiff_t>(first + count), " "));
  }
};

void check_count(const Row& row, std::size_t expected) {
  const std::size_t count = row.words.size();
  if (count == expected) return;
  const std::string found = fmt::format("{} numbers", count);
  if (expected != 0) {
    row.refuse("", found, fmt::format("the rows before have {}", expected), "the row may be cut short");
  }
  row.refuse("", found, "neither a TUM row (8: t tx ty tz qx qy qz qw) nor a KITTI row (12: a 3 x 4 matrix)",
             "give a trajectory in one of the two formats");
}

// All rows, of 8 or 12 words each. They refer to `text`.
std::vector<Row> split_rows(const std::string& file, std::string_view text) {
  std::vector<Row> rows;
  std::size_t line_number = 0;
  for (const std::string_view line : split_lines(text)) {
    ++line_number;
    Row row{fmt::format("{}:{}", file, line_number), fmt::format("pose row {}", rows.size()),
            split_words(line.substr(0, line.find('#')))};
    if (row.words.empty()) continue;
    const std::size_t first_count = rows.empty() ? row.words.size() : rows.front().words.size();
    check_count(row, first_count == kTumNumbers || first_count == kKittiNumbers ? first_count : 0);
    rows.push_back(std::move(row));
  }
  if (rows.empty())
    throw InputError({file, "poses", "0", "the file holds none", "give a TUM or KITTI trajectory"});
  return rows;
}

Time tum_time(const Row& row) {
  (void)row.number(0);
  const std::optional<Time> time = parse_decimal_seconds(row.words[0]);
  if (!time) {
    row.refuse(", time", std::string(row.words[0]), "is not decimal seconds within 126 years of 0",
               "give times in seconds");
  }
  return *time;
}

SE3 tum_pose(const Row& row) {
  const Eigen::Vector3d translation(row.number(1), row.number(2), row.number(3));
  const Eigen::Quaterniond q(row.number(7), row.number(4), row.number(5), row.number(6));
  if (!(std::abs(q.norm() - 1) <= kRotationTolerance)) {
    row.refuse(", quaternion", row.text(4, 4),
               fmt::format("has norm {:.6g} where a rotation has 1", q.norm()),
               "write t tx ty tz qx qy qz qw with a unit quaternion");
  }
  return {q.normalized().toRotationMatrix(), translation};
}

SE3 kitti_pose(const Row& row) {
  Eigen::Matrix<double, 3, 4> T;
  for (std::size_t i = 0; i < kKittiNumbers; ++i) {
    T(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = row.number(i);
  }
  const Eigen::Matrix3d R = T.leftCols<3>();
  if (const auto problem = rotation_problem(R)) {
    row.refuse(", matrix", row.text(0, kKittiNumbers), *problem, "write 3 x 4 matrices [R t], row after row");
  }
  return SE3(R, T.col(3)).normalized();
}

void check_one_row_per_scan(const std::string& file, std::size_t rows, std::size_t scans) {
  if (rows == scans) return;
  throw InputError(
      {file, "poses", fmt::format("{}", rows),
       fmt::format("{} poses than scans: the recording has {} scans", rows < scans ? "fewer" : "more", scans),
       "give one KITTI row per scan, or a TUM file with times"});
}

SE3 sensor_pose(const SE3& pose, const TrajectoryFileOptions& options) {
  const SE3 T_0f = options.direction == PoseDirection::world_from_sensor ? pose : pose.inverse();
  return options.T_file_sensor.inverse() * T_0f.inverse() * options.T_file_sensor;
}

std::string kitti_row(const SE3& T_0v) {
  std::array<double, kKittiNumbers> numbers{};
  const Eigen::Matrix4d T = T_0v.matrix();
  for (std::size_t i = 0; i < kKittiNumbers; ++i) {
    numbers[i] = T(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4));
  }
  return fmt::format("{}\n", fmt::join(numbers, " "));
}

std::string tum_row(Time time, const SE3& T_0v) {
  return fmt::format("{} {}\n", decimal_seconds(time), fmt::join(pose_numbers(T_0v), " "));
}

}  // namespace

SampledTrajectory read_trajectory_file(const std::filesystem::path& file,
                                       const TrajectoryFileOptions& options) {
  return parse_trajectory(read_whole_file(file), file, options);
}

SampledTrajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                                   const TrajectoryFileOptions& options) {
  const std::vector<Row> rows = split_rows(file.string(), text);
  const bool tum = rows.front().words.size() == kTumNumbers;
  if (!tum) check_one_row_per_scan(file.string(), rows.size(), options.row_times.size());
  std::vector<TimedPose> poses;
  poses.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Time time = tum ? tum_time(rows[i]) : options.row_times[i];
    if (tum && i > 0 && time <= poses.back().time) {
      rows[i].refuse(", time", std::string(rows[i].words[0]),
                     fmt::format("not after the row before ({})", decimal_seconds(poses.back().time)),
                     "give every pose once, in order of time");
    }
    poses.push_back({time, sensor_pose(tum ? tum_pose(rows[i]) : kitti_pose(rows[i]), options)});
  }
  return {std::move(poses), options.max_extrapolation, file.string()};
}

std::string kitti_rows(const std::vector<TimedPose>& poses) {
  std::string text;
  for (const TimedPose& pose : poses) text += kitti_row(pose.T_v0.inverse());
  return text;
}

std::string tum_rows(const std::vector<TimedPose>& poses) {
  std::string text;
  for (const TimedPose& pose : poses) text += tum_row(pose.time, pose.T_v0.inverse());
  return text;
}

void write_kitti_poses(const std::filesystem::path& file, const std::vector<TimedPose>& poses) {
  write_file_atomically(file, kitti_rows(poses));
}

void write_tum_trajectory(const std::filesystem::path& file, const std::vector<TimedPose>& poses) {
  write_file_atomically(file, tum_rows(poses));
}

}  // namespace mapless
