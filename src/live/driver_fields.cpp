#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "core/median.hpp"
#include "core/parallel_parts.hpp"
#include "lidar/number_span.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/live/point_cloud2.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::array<std::string_view, 6> kRingNames = {"ring",     "channel", "laser_number",
                                                        "laser_id", "laser",   "line"};
constexpr std::array<std::string_view, 9> kTimeNames = {
    "t", "time", "timestamp", "timestamps", "time_stamp", "stamps", "offset_time", "offset_ns", "gps_time"};

// A lidar sees 300 m at most: a median range beyond this is in millimetres.
constexpr double kMostMedianRange_m = 400;
// Of a cloud, enough points for a median.
constexpr std::size_t kRangeSamples = 2000;
// A turn at 5 to 50 Hz lasts this long in microseconds; as nanoseconds it would be a five-thousandth of one.
constexpr double kShortestTurn_us = 20'000;
constexpr double kLongestTurn_us = 200'000;
// A scan lasts a few hundredths of a second to half a second: floating times that last longer are in a
// smaller unit. As SPAN_UNITS of python/mapless/_fields.py.
constexpr double kMillisecondsFrom = 5;
constexpr double kMicrosecondsFrom = 2e3;
constexpr double kNanosecondsFrom = 1e6;
// Floating times of the Unix epoch, 1973 to 5138, by the unit they must have: 1e11 s is far in the future,
// and 1e11 ms in the past.
constexpr double kEpochFrom_ns = 1e17;
constexpr double kEpochFrom_us = 1e14;
constexpr double kEpochFrom_ms = 1e11;
// Eleven days, as TimeReference::automatic decides.
constexpr double kAbsoluteFrom_s = 1e6;

std::string names_of(std::span<const NamedNumbers> cloud) {
  std::vector<std::string_view> names;
  for (const NamedNumbers& field : cloud) names.push_back(field.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

const NamedNumbers* find(std::span<const NamedNumbers> cloud, std::string_view name) {
  const auto found =
      std::find_if(cloud.begin(), cloud.end(), [&](const NamedNumbers& field) { return field.name == name; });
  return found == cloud.end() ? nullptr : &*found;
}

const NamedNumbers* find_first(std::span<const NamedNumbers> cloud, std::span<const std::string_view> names) {
  for (const std::string_view name : names) {
    if (const NamedNumbers* found = find(cloud, name)) return found;
  }
  return nullptr;
}

NumberSpan axis(std::span<const NamedNumbers> cloud, std::string_view name, const std::string& source) {
  const NamedNumbers* found = find(cloud, name);
  if (found == nullptr) {
    throw InputError({source, "fields", names_of(cloud), fmt::format("no field {}", name),
                      "name the topic of the sensor's points"});
  }
  const NumberType type = found->numbers.type;
  if (type != NumberType::float32 && type != NumberType::float64) {
    throw InputError({source, "field " + found->name, "", "not float32 or float64",
                      "publish positions in metres as floating numbers"});
  }
  return found->numbers;
}

void refuse_livox(std::span<const NamedNumbers> cloud, const std::string& source) {
  if (find(cloud, "tag") == nullptr || find(cloud, "line") == nullptr) return;
  throw InputError({source, "fields", "tag and line", "a Livox cloud, whose pattern does not repeat",
                    "mapless needs a spinning lidar"});
}

template <class Visit>
void for_each_sample(const NumberSpan& numbers, std::size_t step, Visit&& visit) {
  NumberSpan samples = numbers;
  samples.stride_bytes *= step;
  samples.size = (numbers.size + step - 1) / step;
  for_each_number(samples, std::forward<Visit>(visit));
}

void require_metres(const PointFields& fields, const std::string& source) {
  const std::size_t step = std::max<std::size_t>(1, fields.x.size / kRangeSamples);
  std::vector<double> squares((fields.x.size + step - 1) / step, 0);
  for (const NumberSpan* axis : {&fields.x, &fields.y, &fields.z}) {
    for_each_sample(*axis, step, [&](std::size_t i, auto number) {
      squares[i] += static_cast<double>(number) * static_cast<double>(number);
    });
  }
  std::erase_if(squares, [](double square) { return !(square > 0) || !std::isfinite(square); });
  if (squares.empty()) return;
  const double range_m = std::sqrt(median(std::move(squares)));
  if (range_m <= kMostMedianRange_m) return;
  throw InputError({source, "points", fmt::format("median range {:.0f} m", range_m), "are they millimetres?",
                    "give metres"});
}

// Points of a part that are returns: those of the others have any time.
std::vector<char> hits_of(const PointFields& fields, std::size_t begin, std::size_t end) {
  std::vector<char> hit(end - begin);
  for_each_number(fields.y, begin, end, [&](std::size_t i, auto y) { hit[i - begin] = y != 0; });
  for_each_number(fields.x, begin, end, [&](std::size_t i, auto x) {
    char& of_point = hit[i - begin];
    of_point = (of_point || x != 0) && std::isfinite(static_cast<double>(x));
  });
  return hit;
}

struct TimeSpan {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};

TimeSpan span_of(const NumberSpan& times, const PointFields& fields) {
  std::vector<TimeSpan> spans(count_parts(times.size));
  for_parts(times.size, [&](std::size_t part, std::size_t begin, std::size_t end) {
    const std::vector<char> hit = hits_of(fields, begin, end);
    TimeSpan& span = spans[part];
    for_each_number(times, begin, end, [&](std::size_t i, auto number) {
      const auto time = static_cast<double>(number);
      if (!hit[i - begin] || !std::isfinite(time)) return;
      span.least = std::min(span.least, time);
      span.most = std::max(span.most, time);
    });
  });
  TimeSpan all;
  for (const TimeSpan& span : spans) all = {std::min(all.least, span.least), std::max(all.most, span.most)};
  return all;
}

bool is_floating(NumberType type) { return type == NumberType::float32 || type == NumberType::float64; }

TimeUnit unit_of(NumberType type, const TimeSpan& span) {
  const double length = span.most - span.least;
  if (!is_floating(type)) {
    return length >= kShortestTurn_us && length <= kLongestTurn_us ? TimeUnit::microseconds
                                                                   : TimeUnit::nanoseconds;
  }
  if (span.least >= kEpochFrom_ns) return TimeUnit::nanoseconds;
  if (span.least >= kEpochFrom_us) return TimeUnit::microseconds;
  if (span.least >= kEpochFrom_ms) return TimeUnit::milliseconds;
  if (length >= kNanosecondsFrom) return TimeUnit::nanoseconds;
  if (length >= kMicrosecondsFrom) return TimeUnit::microseconds;
  return length >= kMillisecondsFrom ? TimeUnit::milliseconds : TimeUnit::seconds;
}

struct UnitText {
  std::string_view name;
  double per_second;
};

UnitText text_of(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::seconds:
      return {"s", 1};
    case TimeUnit::milliseconds:
      return {"ms", 1e3};
    case TimeUnit::microseconds:
      return {"us", 1e6};
    case TimeUnit::nanoseconds:
      break;
  }
  return {"ns", 1e9};
}

std::string_view text_of(NumberType type) {
  static constexpr std::array<std::string_view, 10> kNames = {
      "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"};
  return kNames[static_cast<std::size_t>(type)];
}

// Sets the times, and returns where they come from.
std::string set_times(std::span<const NamedNumbers> cloud, PointFields& fields) {
  static constexpr std::string_view kRecovered = "times: of points recovered from their azimuths";
  fields.time_reference = TimeReference::automatic;
  const NamedNumbers* time = find_first(cloud, kTimeNames);
  if (time == nullptr) return fmt::format("{}: the cloud has no field for it", kRecovered);
  const NumberType type = time->numbers.type;
  const TimeSpan span = span_of(time->numbers, fields);
  if (!(span.least < span.most))
    return fmt::format("{}: the driver has left the field {} empty", kRecovered, time->name);
  fields.time = time->numbers;
  fields.time_unit = unit_of(type, span);
  const UnitText unit = text_of(fields.time_unit);
  return fmt::format("times: of points from the field {} ({}) in {} {}", time->name, text_of(type), unit.name,
                     span.least / unit.per_second >= kAbsoluteFrom_s ? "of the Unix epoch"
                                                                     : "since the stamp of the message");
}

}  // namespace

DriverFields driver_fields(std::span<const NamedNumbers> cloud, std::size_t rows, const std::string& source) {
  DriverFields found;
  PointFields& fields = found.fields;
  fields.x = axis(cloud, "x", source);
  fields.y = axis(cloud, "y", source);
  fields.z = axis(cloud, "z", source);
  fields.rows = rows;
  refuse_livox(cloud, source);
  require_metres(fields, source);
  const NamedNumbers* ring = find_first(cloud, kRingNames);
  if (ring != nullptr) fields.ring = ring->numbers;
  found.notes.push_back(set_times(cloud, fields));
  found.notes.push_back(ring != nullptr ? "rings: of points from the field " + ring->name
                                        : "rings: recovered: the cloud has no field for it");
  return found;
}

}  // namespace mapless
