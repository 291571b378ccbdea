#include "io/formats/mdlidar/mdlidar_files.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include "core/time_check.hpp"
#include "io/files/text.hpp"
#include "mdlidar.pb.h"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

[[noreturn]] void refuse_corrupt(const fs::path& file, std::size_t size) {
  throw InputError({file.string(), "size", fmt::format("{} bytes", size), "not a whole mdlidar message",
                    "fetch the file again"});
}

template <class Message>
Message parse(const fs::path& file) {
  const std::string bytes = read_whole_file(file);
  Message message;
  if (bytes.empty() || !message.ParseFromString(bytes)) refuse_corrupt(file, bytes.size());
  return message;
}

Eigen::Vector3d vector_of(const mdlidar::Vector3D& v) { return {v.x(), v.y(), v.z()}; }

SE3 pose_of(const mdlidar::Vector3D& position, const mdlidar::Orientation& orientation, const fs::path& file,
            const char* field) {
  const Eigen::Vector3d p = vector_of(position);
  const Eigen::Vector3d axis = vector_of(orientation.axis());
  const double angle = orientation.angle();
  constexpr double kLargestAngle_rad = 4 * std::numbers::pi;  // two turns: another unit, or damage
  const bool finite = p.allFinite() && axis.allFinite() && std::abs(angle) <= kLargestAngle_rad;
  if (!finite || (axis.norm() < 1e-6 && angle != 0)) {
    throw InputError({file.string(), field,
                      fmt::format("position {} {} {}, axis {} {} {}, angle {}", p.x(), p.y(), p.z(), axis.x(),
                                  axis.y(), axis.z(), angle),
                      "not a pose", "fetch the file again"});
  }
  if (angle == 0) return {Eigen::Matrix3d::Identity(), p};
  return {so3_exp(axis.normalized() * angle), p};
}

// Reads the length of an embedded message and goes to its end; `bytes` is its content.
bool read_embedded(CodedInputStream& in, std::string_view& bytes) {
  std::uint32_t size = 0;
  if (!in.ReadVarint32(&size)) return false;
  const void* data = nullptr;
  int available = 0;
  if (size > 0 && !in.GetDirectBufferPointer(&data, &available)) return false;
  if (size > static_cast<std::uint32_t>(available)) return false;
  bytes = {static_cast<const char*>(data), size};
  return in.Skip(static_cast<int>(size));
}

// Reads a frame. Its points are handed over one by one and not kept in `frame`: as messages, 128,000 of them
// would take many times the size of the file.
bool parse_frame(const std::string& bytes, mdlidar::Frame& frame,
                 const std::function<bool(std::string_view)>& take_point) {
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
  while (const std::uint32_t tag = in.ReadTag()) {
    std::uint64_t number = 0;
    std::string_view point;
    switch (tag) {
      case WireFormatLite::MakeTag(mdlidar::Frame::kStartTimeFieldNumber, WireFormatLite::WIRETYPE_VARINT):
        if (!in.ReadVarint64(&number)) return false;
        frame.set_start_time(static_cast<std::int64_t>(number));
        break;
      case WireFormatLite::MakeTag(mdlidar::Frame::kEndTimeFieldNumber, WireFormatLite::WIRETYPE_VARINT):
        if (!in.ReadVarint64(&number)) return false;
        frame.set_end_time(static_cast<std::int64_t>(number));
        break;
      case WireFormatLite::MakeTag(mdlidar::Frame::kStateFieldNumber,
                                   WireFormatLite::WIRETYPE_LENGTH_DELIMITED):
        if (!WireFormatLite::ReadMessage(&in, frame.mutable_state())) return false;
        break;
      case WireFormatLite::MakeTag(mdlidar::Frame::kPointsFieldNumber,
                                   WireFormatLite::WIRETYPE_LENGTH_DELIMITED):
        if (!read_embedded(in, point) || !take_point(point)) return false;
        break;
      default:
        if (!WireFormatLite::SkipField(&in, tag)) return false;
    }
  }
  return in.ConsumedEntireMessage();
}

std::array<double, 4> numbers_of_row(const std::string& line, const std::string& where) {
  std::array<double, 4> row{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t i = 0; i < row.size(); ++i) {
    while (at != end && (*at == ' ' || *at == '\t' || (i > 0 && *at == ','))) ++at;
    const auto [rest, error] = std::from_chars(at, end, row[i]);
    if (error != std::errc() || !std::isfinite(row[i])) {
      throw InputError({where, "row", line, "not four numbers",
                        "horizontal and vertical offset, rotational and vertical "
                        "correction are needed for every laser"});
    }
    at = rest;
  }
  if (at != end)
    throw InputError({where, "row", line, "more than four numbers", "remove the surplus numbers"});
  return row;
}

// As lidar_model.cpp: a value beyond was given in another unit, or is damaged.
constexpr double kFarthestOffset_m = 10, kLargestAngle_rad = 4 * std::numbers::pi;

void require_plausible(const std::array<double, 4>& row, const std::string& where) {
  constexpr std::array kNames = {"horizontal offset", "vertical offset", "rotational correction",
                                 "vertical correction"};
  for (std::size_t i = 0; i < row.size(); ++i) {
    const bool offset = i < 2;
    const double most = offset ? kFarthestOffset_m : kLargestAngle_rad;
    if (std::abs(row[i]) <= most) continue;
    throw InputError({where, kNames[i], fmt::format("{}", row[i]),
                      fmt::format("beyond {:.4g} {}", most, offset ? "m" : "rad"),
                      "give offsets in metres and corrections in radians"});
  }
}

}  // namespace

std::vector<MdlidarLaser> read_mdlidar_calibration(const fs::path& file) {
  std::vector<MdlidarLaser> lasers;
  const std::vector<std::string> lines = read_lines(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string where = fmt::format("{}:{}", file.string(), i + 1);
    const auto row = numbers_of_row(lines[i], where);
    require_plausible(row, where);
    lasers.push_back({row[0], row[1], row[2], row[3]});
  }
  return lasers;
}

mdlidar::Header read_mdlidar_header(const fs::path& file) {
  auto header = parse<mdlidar::Header>(file);
  if (header.channels_count() < 1 || header.points_count_by_channel() < 2 ||
      header.points_count_by_channel() > 1'000'000) {
    throw InputError({file.string(), "channels_count x points_count_by_channel",
                      fmt::format("{} x {}", header.channels_count(), header.points_count_by_channel()),
                      "a turn has at least one channel of 2 to 1000000 points", "fetch the file again"});
  }
  return header;
}

void read_mdlidar_points(const fs::path& file, std::size_t points,
                         const std::function<void(std::size_t, const MdlidarPoint&)>& visit) {
  const std::string bytes = read_whole_file(file);
  mdlidar::Frame frame;
  mdlidar::Point message;
  std::size_t count = 0;
  const auto take_point = [&](std::string_view point) {
    if (!message.ParseFromArray(point.data(), static_cast<int>(point.size()))) return false;
    if (count < points) {
      visit(count, {message.range(), message.rotation(), message.object_id(), message.dynamic()});
    }
    ++count;
    return true;
  };
  if (bytes.empty() || !parse_frame(bytes, frame, take_point)) refuse_corrupt(file, bytes.size());
  require_mdlidar_points(file, count, points);
}

void require_mdlidar_points(const fs::path& file, std::size_t points, std::size_t of_header) {
  if (points == of_header) return;
  throw InputError({file.string(), "points", std::to_string(points),
                    fmt::format("the header has {}", of_header), "fetch the file again"});
}

MdlidarFrameSummary read_mdlidar_summary(const fs::path& file) {
  const std::string bytes = read_whole_file(file);
  mdlidar::Frame frame;
  MdlidarFrameSummary summary;
  const auto count_point = [&summary](std::string_view) { return ++summary.points > 0; };
  if (bytes.empty() || !parse_frame(bytes, frame, count_point)) refuse_corrupt(file, bytes.size());
  summary.start = Time::from_nanoseconds(frame.start_time());
  summary.end = Time::from_nanoseconds(frame.end_time());
  require_time(file.string(), "start_time", summary.start);
  require_time(file.string(), "end_time", summary.end);
  const std::int64_t length = frame.end_time() - frame.start_time();
  if (length <= 0 || length > 1'000'000'000) {
    throw InputError({file.string(), "end_time", std::to_string(frame.end_time()),
                      fmt::format("{} ns after start_time", length),
                      "a turn takes more than 0 and at most 1 s"});
  }
  if (!frame.has_state()) {
    throw InputError({file.string(), "state", "", "missing: the pose of the sensor", "fetch the file again"});
  }
  const mdlidar::State& state = frame.state();
  summary.pose_p = pose_of(state.position_p(), state.orientation_p(), file, "state_p");
  summary.pose = pose_of(state.position(), state.orientation(), file, "state");
  return summary;
}

}  // namespace mapless
