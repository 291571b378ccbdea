#include "benchmark/speed/speed_plots.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "reports/json.hpp"

namespace mapless::app {
namespace {

double processor_ms(const Json& sensor, const std::string& name) {
  for (const Json& row : sensor["rows"]) {
    if (row["name"] == name) return row["processor_ms"];
  }
  return 0;
}

std::vector<Json> by_rays(const Json& speed) {
  std::vector<Json> sensors(speed["sensors"].begin(), speed["sensors"].end());
  std::stable_sort(sensors.begin(), sensors.end(), [](const Json& a, const Json& b) {
    return a["rays"].get<std::size_t>() < b["rays"].get<std::size_t>();
  });
  return sensors;
}

double largest(const std::vector<PlotLine>& lines, double std::pair<double, double>::*coordinate) {
  double out = 0;
  for (const PlotLine& line : lines) {
    for (const auto& point : line.points) out = std::max(out, point.*coordinate);
  }
  return out;
}

Plot with_axes(std::string title, Axis x, std::string y_name, std::vector<PlotLine> lines) {
  Axis y = axis_from_zero(std::move(y_name), largest(lines, &std::pair<double, double>::second));
  return {std::move(title), std::move(x), std::move(y), std::move(lines)};
}

}  // namespace

Plot time_against_rays(const Json& speed) {
  std::vector<PlotLine> lines;
  for (const char* name : {"pipeline", "on two threads", "detection", "odometry"}) {
    PlotLine line;
    line.name = name;
    line.color = lines.size();
    for (const Json& sensor : by_rays(speed)) {
      line.points.emplace_back(sensor["rays"].get<double>() / 1000, processor_ms(sensor, name));
      if (lines.empty()) line.point_names.push_back(sensor["sensor"]);
    }
    lines.push_back(std::move(line));
  }
  // Room for the name of the last sensor.
  Axis x =
      axis_from_zero("thousand rays in a scan", 1.25 * largest(lines, &std::pair<double, double>::first));
  return with_axes(fmt::format("Time against rays, {}", speed["scene"].get<std::string>()), std::move(x),
                   "processor time of a scan [ms]", std::move(lines));
}

Plot time_against_threads(const Json& speed) {
  const Json& sensor = speed["sensors"][0];
  std::vector<PlotLine> lines(2);
  lines[0].name = "one after the other";
  lines[1].name = "odometry beside it";
  lines[1].color = 1;
  for (const Json& run : sensor["threads"]) {
    lines[run["side_by_side"].get<bool>() ? 1 : 0].points.emplace_back(run["threads"].get<double>(),
                                                                       run["median_ms"].get<double>());
  }
  for (PlotLine& line : lines) std::sort(line.points.begin(), line.points.end());
  Axis x{"threads", 0, largest(lines, &std::pair<double, double>::first), 1};
  return with_axes(fmt::format("Odometry and detection against threads, {} in {}",
                               sensor["sensor"].get<std::string>(), speed["scene"].get<std::string>()),
                   std::move(x), "time of a scan [ms]", std::move(lines));
}

}  // namespace mapless::app
