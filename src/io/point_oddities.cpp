#include "io/point_oddities.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "core/median.hpp"

namespace mapless::inline v1 {
namespace {

// Points a median is taken of: fewer than 100 show nothing, more than 2000 do not change it.
constexpr std::size_t kFewest = 100, kMost = 2000;
// Median range over the maximum range. Another unit is a factor of ten and more.
constexpr double kBeyondRange = 1.1;
// Median angle between points and their beams. Recovered columns and real sensors are within a degree of
// their model; another sensor, direction or start azimuth is tens of degrees off.
constexpr double kOffBeam_rad = 3 * std::numbers::pi / 180;
// Times are checked if the columns of the points span a quarter of a turn, and are implausible if they span
// less than a tenth of the time for that: another unit is a factor of 1000.
constexpr double kLeastTurn = 0.25;
constexpr double kTooShort = 0.1;

std::vector<const LidarReturn*> some_returns(const LidarScan& scan) {
  std::vector<const LidarReturn*> some;
  const std::size_t step = 1 + scan.returns.size() / kMost;
  for (std::size_t i = 0; i < scan.returns.size(); i += step) some.push_back(&scan.returns[i]);
  return some;
}

double median_range_m(const std::vector<const LidarReturn*>& returns) {
  std::vector<double> ranges;
  for (const LidarReturn* r : returns) ranges.push_back(r->range_m);
  return median(std::move(ranges));
}

double median_off_beam_rad(const LidarScan& scan, const std::vector<const LidarReturn*>& returns) {
  std::vector<double> angles;
  for (const LidarReturn* r : returns) {
    const Eigen::Vector3d expected = scan.model->point_v(r->laser, r->column, r->range_m);
    angles.push_back((r->position_v.cast<double>() - expected).norm() / r->range_m);
  }
  return median(std::move(angles));
}

/// Time from the first to the last point [s]: by their times, and by their columns.
struct Spans {
  double times_s, columns_s;
};

Spans spans_of(const LidarScan& scan, const std::vector<const LidarReturn*>& returns) {
  const auto [first, last] =
      std::minmax_element(returns.begin(), returns.end(),
                          [](const LidarReturn* a, const LidarReturn* b) { return a->time_ns < b->time_ns; });
  const auto [begin, end] =
      std::minmax_element(returns.begin(), returns.end(),
                          [](const LidarReturn* a, const LidarReturn* b) { return a->column < b->column; });
  return {1e-9 * (static_cast<double>((*last)->time_ns) - (*first)->time_ns),
          ((*end)->column - (*begin)->column) * scan.column_period.seconds()};
}

}  // namespace

void PointOddities::add(const LidarScan& scan, std::size_t k) {
  if (scan.returns.size() < kFewest) return;
  const auto returns = some_returns(scan);
  const double range_m = median_range_m(returns);
  if (range_m > kBeyondRange * scan.model->max_range_m) {
    found("range", k,
          fmt::format(
              "half of the points are {:.0f} m away or farther, and the sensor sees no farther than {:g} m: "
              "in another unit?",
              range_m, scan.model->max_range_m));
  }
  // Motion compensation moves points off their beams.
  const double off_rad = scan.compensated_to ? 0 : median_off_beam_rad(scan, returns);
  if (off_rad > kOffBeam_rad) {
    found("beam", k,
          fmt::format("half of the points are {:.0f} degrees or more off the beams of {}: another sensor, "
                      "direction of turning or start azimuth?",
                      off_rad * 180 / std::numbers::pi, scan.model->name));
  }
  const Spans spans = spans_of(scan, returns);
  const double turn_s = scan.column_period.seconds() * scan.columns;
  if (scan.time_source == Provenance::sensor && spans.columns_s > kLeastTurn * turn_s &&
      spans.times_s < kTooShort * spans.columns_s) {
    found("times", k,
          fmt::format("the times of the points span {:.6f} s, where the sensor turned for {:.6f} s: "
                      "in another unit?",
                      spans.times_s, spans.columns_s));
  }
}

void PointOddities::found(const std::string& kind, std::size_t k, const std::string& text) {
  Found& f = found_[kind];
  if (f.scans++ > 0) return;
  f.first = k;
  f.text = text;
}

std::vector<std::string> PointOddities::lines() const {
  std::vector<std::string> out;
  for (const auto& [kind, f] : found_) {
    const std::string others = f.scans > 1 ? fmt::format(" (and {} others)", f.scans - 1) : "";
    out.push_back(fmt::format("scan {}{}: {}", f.first, others, f.text));
  }
  return out;
}

}  // namespace mapless
