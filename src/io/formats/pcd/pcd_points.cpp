#include "io/formats/pcd/pcd_points.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include <fmt/format.h>

#include "io/formats/pcd/pcd.hpp"
#include "lidar/ring_recovery.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Times from 1e15 ns on (11.6 days) are absolute: no scan is as long, and no Unix time is as small.
constexpr std::int64_t kAbsoluteFromNs = 1'000'000'000'000'000;
// Bound of a time [s]: the difference of two times within it fits an int64 of nanoseconds.
constexpr double kLargestSeconds = 4e9;

const PcdField* first_of(const PcdCloud& cloud, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (const PcdField* field = cloud.find(name)) return field;
  }
  return nullptr;
}

std::vector<std::int64_t> integers_as_ns(const PcdCloud& cloud, const PcdField& field) {
  std::vector<std::int64_t> times = cloud.integers(field);
  const auto largest_ns = static_cast<std::int64_t>(kLargestSeconds * 1e9);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] >= -largest_ns && times[i] <= largest_ns) continue;
    throw InputError({cloud.file.string(), fmt::format("point {} {}", i, field.name),
                      std::to_string(times[i]), "not a time in nanoseconds",
                      "record integers of ns, or floating seconds"});
  }
  return times;
}

std::vector<std::int64_t> seconds_as_ns(const PcdCloud& cloud, const PcdField& field,
                                        const std::vector<Eigen::Vector3f>& positions) {
  const std::vector<double> seconds = cloud.doubles(field);
  std::vector<std::int64_t> out(seconds.size(), 0);
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    if (!is_usable(positions[i])) continue;
    const auto refuse = [&](const char* problem, const char* remedy) {
      throw InputError({cloud.file.string(), fmt::format("point {} {}", i, field.name),
                        fmt::format("{}", seconds[i]), problem, remedy});
    };
    if (!(std::abs(seconds[i]) < kLargestSeconds))
      refuse("not a time in seconds", "record seconds, or integers of ns");
    out[i] = Duration::from_seconds(seconds[i]).nanoseconds();
    if (field.size == 4 && out[i] >= kAbsoluteFromNs) {
      refuse("an absolute time in 4 bytes, which does not resolve a second",
             "record times since the scan's start, or 8 bytes");
    }
  }
  return out;
}

}  // namespace

std::optional<std::int64_t> PcdPoints::first_time_ns() const {
  std::optional<std::int64_t> first;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    if (is_usable(positions[i])) first = std::min(first.value_or(times_ns[i]), times_ns[i]);
  }
  return first;
}

PcdPoints read_pcd_points(const std::filesystem::path& file) {
  const PcdCloud cloud = read_pcd(file);
  const std::vector<float> x = cloud.floats(cloud.require("x")), y = cloud.floats(cloud.require("y")),
                           z = cloud.floats(cloud.require("z"));
  PcdPoints points;
  points.positions.resize(cloud.size());
  points.rows = cloud.height;
  for (std::size_t i = 0; i < cloud.size(); ++i) points.positions[i] = {x[i], y[i], z[i]};
  if (const PcdField* ring = first_of(cloud, {"ring", "laser"})) points.rings = cloud.integers(*ring);
  if (const PcdField* time = first_of(cloud, {"t", "time", "timestamp"})) {
    points.times_ns =
        time->is_floating() ? seconds_as_ns(cloud, *time, points.positions) : integers_as_ns(cloud, *time);
    points.times_are_absolute = points.first_time_ns().value_or(0) >= kAbsoluteFromNs;
  }
  return points;
}

}  // namespace mapless
