#include "lidar/scan_builder/raw_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "core/parallel_parts.hpp"
#include "lidar/number_span.hpp"
#include "lidar/recovery/ring_recovery.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Eleven days: no scan lasts as long, and no clock that counts from 1970 shows less.
constexpr std::int64_t kAbsoluteFrom_ns = 1'000'000'000'000'000;
// 127 years: differences of times below it do not overflow 64 bits of nanoseconds.
constexpr double kLargest_s = 4e9;
// A float of 4 bytes holds 24 bits: from here on (a quarter of an hour) it cannot tell 0.1 ms apart, which is
// two columns of a turn of 0.1 s.
constexpr std::int64_t kCoarseFrom_ns = 1'000'000'000'000;

std::string point_field(std::size_t i, const char* name) { return fmt::format("point {} {}", i, name); }

void require_lengths(const PointFields& fields, const std::string& source) {
  const std::size_t count = fields.x.size;
  const auto require = [&](const char* name, const NumberSpan& numbers, bool needed) {
    if (numbers.size == count || (!needed && numbers.empty())) return;
    throw InputError({source, name, fmt::format("{} numbers", numbers.size),
                      fmt::format("not one per point: x has {}", count),
                      "give every field with one number per point"});
  };
  require("y", fields.y, true);
  require("z", fields.z, true);
  require("ring", fields.ring, false);
  require("time", fields.time, false);
  if (fields.rows > 0 && count % fields.rows == 0) return;
  throw InputError({source, "rows", std::to_string(fields.rows),
                    fmt::format("{} points do not make so many rows of one length", count),
                    "give 1 for a cloud that is not organised"});
}

template <class Number>
bool is_integer(Number number) {
  if constexpr (std::is_floating_point_v<Number>) {
    return std::abs(number) < static_cast<Number>(9.2e18) && std::trunc(number) == number;
  } else {
    return std::in_range<std::int64_t>(number);
  }
}

void read_rings(const NumberSpan& rings, std::size_t begin, std::size_t end, RawPoints& points,
                const std::string& source) {
  for_each_number(rings, begin, end, [&](std::size_t i, auto number) {
    if (!is_integer(number)) {
      if (!is_usable(points.positions[i])) return;
      throw InputError({source, point_field(i, "ring"), fmt::format("{}", number), "not an integer",
                        "give the number of the laser, from 0, as integers"});
    }
    points.rings[i] = static_cast<std::int64_t>(number);
  });
}

std::int64_t nanoseconds_per(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::seconds:
      return 1'000'000'000;
    case TimeUnit::milliseconds:
      return 1'000'000;
    case TimeUnit::microseconds:
      return 1'000;
    case TimeUnit::nanoseconds:
      return 1;
  }
  return 1;
}

const char* name_of(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::seconds:
      return "seconds";
    case TimeUnit::milliseconds:
      return "milliseconds";
    case TimeUnit::microseconds:
      return "microseconds";
    case TimeUnit::nanoseconds:
      return "nanoseconds";
  }
  return "";
}

// Times of points without a return are not read: drivers leave anything there.
// Returns the earliest.
std::optional<std::int64_t> read_times(const PointFields& fields, std::size_t begin, std::size_t end,
                                       RawPoints& points, const std::string& source) {
  std::optional<std::int64_t> first;
  const std::int64_t unit_ns = nanoseconds_per(fields.time_unit);
  for_each_number(fields.time, begin, end, [&](std::size_t i, auto number) {
    if (!is_usable(points.positions[i])) return;
    std::int64_t& time_ns = points.times_ns[i];
    const auto refuse = [&](const std::string& problem, const char* remedy) {
      throw InputError({source, point_field(i, "time"), fmt::format("{}", number), problem, remedy});
    };
    const double seconds = static_cast<double>(number) * (static_cast<double>(unit_ns) * 1e-9);
    if (!(std::abs(seconds) < kLargest_s))
      refuse(fmt::format("not a time in {}", name_of(fields.time_unit)), "name the unit that the times have");
    if constexpr (std::is_floating_point_v<decltype(number)>) {
      const auto exact = static_cast<double>(number);
      time_ns = fields.time_unit == TimeUnit::seconds
                    ? Duration::from_seconds(exact).nanoseconds()
                    : static_cast<std::int64_t>(std::llround(exact * static_cast<double>(unit_ns)));
    } else {
      time_ns = static_cast<std::int64_t>(number) * unit_ns;
    }
    if (fields.time.type == NumberType::float32 && time_ns >= kCoarseFrom_ns) {
      refuse("a time of 4 bytes that cannot tell two columns apart",
             "give times since the scan's stamp, or 8 bytes");
    }
    first = std::min(first.value_or(time_ns), time_ns);
  });
  return first;
}

}  // namespace

RawPoints read_points(const PointFields& fields, const std::string& source) {
  require_lengths(fields, source);
  RawPoints points;
  points.rows = fields.rows;
  points.positions.resize(fields.x.size);
  points.rings.assign(fields.ring.size, -1);
  points.times_ns.assign(fields.time.size, 0);
  // First all rings, then all times: which of two faults is named does not depend on their places.
  const NumberSpan* axes[] = {&fields.x, &fields.y, &fields.z};
  for_parts(fields.x.size, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (int axis = 0; axis < 3; ++axis) {
      for_each_number(*axes[axis], begin, end, [&](std::size_t i, auto number) {
        points.positions[i][axis] = static_cast<float>(number);
      });
    }
    if (!fields.ring.empty()) read_rings(fields.ring, begin, end, points, source);
  });
  std::vector<std::optional<std::int64_t>> first(count_parts(fields.time.size));
  for_parts(fields.time.size, [&](std::size_t part, std::size_t begin, std::size_t end) {
    first[part] = read_times(fields, begin, end, points, source);
  });
  for (const auto& of_part : first) {
    if (of_part) points.first_time_ns = std::min(points.first_time_ns.value_or(*of_part), *of_part);
  }
  points.times_are_absolute =
      fields.time_reference == TimeReference::epoch || (fields.time_reference == TimeReference::automatic &&
                                                        points.first_time_ns.value_or(0) >= kAbsoluteFrom_ns);
  return points;
}

}  // namespace mapless
