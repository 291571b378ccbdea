#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/tables/csv.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::string_view kSpeedHead = "time_s,speed_m_s";
constexpr std::string_view kAngularVelocityHead = "time_s,x_rad_s,y_rad_s,z_rad_s";

// As --initial-velocity; twice what gyroscopes measure, less than many a rate in degrees.
constexpr double kFastest_mps = 200, kFastest_rad_s = 50;

double bounded(const CsvLine& line, std::size_t i, MeasuredMotion quantity) {
  const bool is_speed = quantity == MeasuredMotion::speed;
  const double value = line.number(i);
  if (is_speed && std::abs(value) > kFastest_mps)
    line.refuse("speed_m_s", line.cells[i], fmt::format("more than {} m/s", kFastest_mps));
  if (!is_speed && std::abs(value) > kFastest_rad_s)
    line.refuse("angular velocity", line.cells[i],
                fmt::format("more than {} rad/s; degrees?", kFastest_rad_s));
  return value;
}

std::vector<MotionMeasurement> read(const std::filesystem::path& file, std::string_view head,
                                    MeasuredMotion quantity) {
  const std::string remedy = "give a first line " + std::string(head) + " and rows by increasing time";
  const std::string text = read_whole_file(file);
  std::vector<MotionMeasurement> out;
  for (const CsvLine& line : csv_lines(file, text, head, remedy)) {
    MotionMeasurement one{line.time(0, "time_s"), quantity, Eigen::Vector3d::Zero(), std::nullopt};
    for (std::size_t i = 1; i < line.cells.size(); ++i)
      one.value[static_cast<Eigen::Index>(i) - 1] = bounded(line, i, quantity);
    if (!out.empty() && one.time <= out.back().time)
      line.refuse("time_s", line.cells[0], "not after the time before it");
    if (quantity == MeasuredMotion::speed && one.value.x() < 0)
      line.refuse("speed_m_s", line.cells[1], "negative: a speed is the norm of the velocity");
    out.push_back(one);
  }
  if (out.empty()) throw InputError({file.string(), "rows", "0", "no measurement", remedy});
  return out;
}

}  // namespace

std::vector<MotionMeasurement> read_speeds(const std::filesystem::path& file) {
  return read(file, kSpeedHead, MeasuredMotion::speed);
}

std::vector<MotionMeasurement> read_angular_velocities(const std::filesystem::path& file) {
  return read(file, kAngularVelocityHead, MeasuredMotion::angular_velocity);
}

}  // namespace mapless
