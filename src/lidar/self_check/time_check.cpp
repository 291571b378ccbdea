#include "lidar/self_check/time_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/median.hpp"

namespace mapless::inline v1 {
namespace {

// Columns are checked where they span a quarter of a turn.
constexpr double kLeastTurn = 0.25;
// Time of a turn by the points, over that by the columns. Sensors keep their rate to a few per cent; a rate
// that is off by a third moves the last point of a turn by a third of the motion during it.
constexpr double kDoubtfulRate = 0.15, kWrongRate = 0.35;
// Median distance of the times from their line, in turns. Firing patterns are below 0.001.
constexpr double kDoubtfulScatter = 0.02, kWrongScatter = 0.08;
// Times that span less than this share of the turn are those of the lasers within a column, at most.
constexpr double kOneTime = 0.01;
// Spinning lidars turn at 5 to 20 Hz by their data sheets. A slower one than this, or a faster one, has times
// that are ten times too long or too short.
constexpr double kSlowest_hz = 2.5, kFastest_hz = 45;

struct TimeLine {
  double span_turns = 0;   // of the columns
  double rate = 0;         // slope: time by the points over time by the columns
  double scatter = 0;      // median distance from the line, in turns
  double time_span_s = 0;  // from the first to the last point
};

TimeLine time_line(const LidarScan& scan) {
  std::vector<double> columns, times;
  const double turn_s = scan.column_period.seconds() * scan.model->columns;
  const std::size_t step = 1 + scan.returns.size() / kMostSamples;
  for (std::size_t i = 0; i < scan.returns.size(); i += step) {
    const LidarReturn& r = scan.returns[i];
    const Duration offset = scan.model->lasers[static_cast<std::size_t>(r.laser)].firing_offset;
    columns.push_back(r.column * scan.column_period.seconds() / turn_s);
    times.push_back((1e-9 * r.time_ns - offset.seconds()) / turn_s);
  }
  TimeLine line;
  const auto [c0, c1] = std::minmax_element(columns.begin(), columns.end());
  const auto [t0, t1] = std::minmax_element(times.begin(), times.end());
  line.span_turns = *c1 - *c0;
  line.time_span_s = (*t1 - *t0) * turn_s;
  const auto n = static_cast<double>(columns.size());
  double mean_c = 0, mean_t = 0, cc = 0, ct = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    mean_c += columns[i] / n;
    mean_t += times[i] / n;
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    cc += (columns[i] - mean_c) * (columns[i] - mean_c);
    ct += (columns[i] - mean_c) * (times[i] - mean_t);
  }
  if (cc <= 0) return line;
  line.rate = ct / cc;
  for (std::size_t i = 0; i < columns.size(); ++i)
    times[i] = std::abs(times[i] - mean_t - line.rate * (columns[i] - mean_c));
  line.scatter = median(std::move(times));
  return line;
}

struct UnitOfTime {
  const char* name;
  double nanoseconds;
};
constexpr std::array<UnitOfTime, 3> kUnitsOfTime = {
    {{"microseconds", 1e3}, {"milliseconds", 1e6}, {"seconds", 1e9}}};

std::string time_mistake(const TimeLine& line, const LidarScan& scan) {
  if (line.scatter > kDoubtfulScatter) return "they do not follow the order of the columns";
  if (std::abs(line.rate + 1) < kWrongRate) return "the times run backwards, or the columns do";
  for (const UnitOfTime& unit : kUnitsOfTime) {
    if (std::abs(line.rate * unit.nanoseconds - 1) < kWrongRate)
      return fmt::format("times look like {}", unit.name);
    if (std::abs(line.rate / unit.nanoseconds - 1) < kWrongRate)
      return fmt::format("times look {:g} times too large", unit.nanoseconds);
  }
  if (std::abs(line.rate) < kOneTime) return "all points have about one time";
  return fmt::format(
      "the sensor turns at {:.2f} Hz by the times of the points, at {:.2f} Hz by its description "
      "(rate_hz)",
      1 / (line.rate * scan.column_period.seconds() * scan.model->columns),
      1 / (scan.column_period.seconds() * scan.model->columns));
}

Trust trust_of(const TimeLine& line) {
  const double off = std::abs(line.rate - 1);
  if (off > kWrongRate || line.scatter > kWrongScatter) return Trust::wrong;
  return off > kDoubtfulRate || line.scatter > kDoubtfulScatter ? Trust::doubtful : Trust::right;
}

}  // namespace

ScanFinding check_point_times(const LidarScan& scan) {
  ScanFinding found;
  if (scan.time_source != Provenance::sensor) {
    found.measured = "not checked: recovered from the columns";
    return found;
  }
  if (scan.returns.size() < kFewestSamples) {
    found.measured = fmt::format("not checked: {} points", scan.returns.size());
    return found;
  }
  const TimeLine line = time_line(scan);
  if (line.span_turns < kLeastTurn) {
    found.measured = "not checked: less than a quarter of a turn";
    return found;
  }
  const double turn_s = scan.column_period.seconds() * scan.model->columns;
  found.size = std::abs(line.rate - 1) + line.scatter;
  found.measured = fmt::format(
      "the points need {:.4f} s for a turn, the sensor {:.4f} s; half of the times are within "
      "{:.4f} s of their columns",
      line.rate * turn_s, turn_s, line.scatter * turn_s);
  found.trust = trust_of(line);
  if (found.trust == Trust::right) return found;
  found.problem =
      fmt::format("the times of the points span {:.6f} s, where the sensor turned for {:.6f} s: {}",
                  line.time_span_s, line.span_turns * turn_s, time_mistake(line, scan));
  found.remedy = "correct the times of the points, or the rate of the sensor";
  return found;
}

ScanFinding check_rate(const LidarModel& model) {
  const double rate_hz = model.rotation_rate_hz;
  ScanFinding found;
  found.trust = rate_hz < kSlowest_hz || rate_hz > kFastest_hz ? Trust::doubtful : Trust::right;
  found.measured = fmt::format("a turn takes {:.4f} s", 1 / rate_hz);
  if (found.trust == Trust::right) return found;
  found.problem = fmt::format(
      "{} turns at {:.3g} Hz, where spinning lidars turn at 5 to 20 Hz: times look about ten times too {}",
      model.name, rate_hz, rate_hz < kSlowest_hz ? "long" : "short");
  found.remedy = "correct the times, or the rate of the sensor";
  return found;
}

}  // namespace mapless
