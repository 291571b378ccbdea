#include "lidar/self_check/beam_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/median.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kNearest_m = 2;
// BeamTolerance. Half the distance between lasers keeps a point at its laser; calibrations of one type of
// sensor differ by tenths of a degree, and two columns are the rounding of a column at either end.
constexpr double kLeastElevation_rad = 0.2 * kDegree, kMostElevation_rad = 1.0 * kDegree;
constexpr double kLeastAzimuth_rad = 0.5 * kDegree, kColumnsOff = 2;
// Misfit beyond which a scan is wrong; between 1 and this it is doubtful. Twice the tolerance is the next
// laser, or four columns: evidence is looked up on other rays than those that passed.
constexpr double kWrongMisfit = 2;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

// The laser that is farthest off its elevation and azimuth, by the median of its samples.
struct WorstLaser {
  int laser = 0;
  double misfit = 0;
};

WorstLaser worst_laser(const std::vector<BeamSample>& samples, const BeamErrors& errors,
                       const BeamTolerance& tolerance, std::size_t lasers) {
  std::vector<BeamErrors> by_laser(lasers);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    BeamErrors& own = by_laser[static_cast<std::size_t>(samples[i].laser)];
    own.elevation.push_back(errors.elevation[i]);
    own.azimuth.push_back(errors.azimuth[i]);
  }
  WorstLaser worst;
  for (std::size_t l = 0; l < lasers; ++l) {
    if (by_laser[l].elevation.size() < kFewestOfLaser) continue;
    const double misfit = by_laser[l].misfit(tolerance);
    if (misfit > worst.misfit) worst = {static_cast<int>(l), misfit};
  }
  return worst;
}

double median_degrees(std::vector<double> errors) {
  for (double& e : errors) e = std::abs(e);
  return median(std::move(errors)) / kDegree;
}

}  // namespace

std::vector<BeamSample> beam_samples(const LidarScan& scan) {
  std::vector<BeamSample> samples;
  const std::size_t step = 1 + scan.returns.size() / kMostSamples;
  for (std::size_t i = 0; i < scan.returns.size(); i += step) {
    const LidarReturn& r = scan.returns[i];
    if (r.range_m < kNearest_m) continue;
    samples.push_back({r.position_v.cast<double>(), r.laser, r.column, scan.time_of(r)});
  }
  return samples;
}

BeamTolerance beam_tolerance(const LidarModel& model) {
  std::vector<double> steps = {2 * kMostElevation_rad};
  if (model.lasers.size() > 1) steps.clear();
  for (std::size_t l = 1; l < model.lasers.size(); ++l) {
    steps.push_back(model.lasers[l].elevation_rad - model.lasers[l - 1].elevation_rad);
  }
  const double column_rad = 2 * std::numbers::pi / model.columns;
  return {std::clamp(median(std::move(steps)) / 2, kLeastElevation_rad, kMostElevation_rad),
          std::max(kLeastAzimuth_rad, kColumnsOff * column_rad)};
}

double BeamErrors::misfit(const BeamTolerance& tolerance) const {
  if (elevation.empty()) return 0;
  std::vector<double> sizes(elevation.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    sizes[i] = std::max(std::abs(elevation[i]) / tolerance.elevation_rad,
                        std::abs(azimuth[i]) / tolerance.azimuth_rad);
  }
  return median(std::move(sizes));
}

BeamErrors beam_errors(const std::vector<BeamSample>& samples, const LidarModel& model) {
  BeamErrors errors;
  for (const BeamSample& sample : samples) {
    const Laser& laser = model.lasers[static_cast<std::size_t>(sample.laser)];
    const double hub = model.hub_angle(sample.column);
    const Eigen::Vector3d beam = sample.position_v - rotation_z(hub) * laser.origin_h_m;
    const double across = beam.head<2>().norm();
    errors.elevation.push_back(std::atan2(beam.z(), across) - laser.elevation_rad);
    errors.azimuth.push_back(wrapped(std::atan2(beam.y(), beam.x()) - hub - laser.azimuth_offset_rad));
  }
  return errors;
}

ScanFinding check_beams(const LidarScan& scan, const GivenPoses& given) {
  ScanFinding found;
  if (scan.compensated_to) {
    found.measured = "not checked: motion compensation has moved the points off their beams";
    return found;
  }
  const std::vector<BeamSample> samples = beam_samples(scan);
  if (samples.size() < kFewestSamples) {
    found.measured = "not checked: too few points";
    return found;
  }
  const LidarModel& model = *scan.model;
  const BeamTolerance tolerance = beam_tolerance(model);
  const BeamErrors errors = beam_errors(samples, model);
  const WorstLaser worst = worst_laser(samples, errors, tolerance, model.lasers.size());
  const double misfit = errors.misfit(tolerance);
  found.size = std::max(misfit, worst.misfit);
  found.measured = fmt::format(
      "half of the points are within {:.2f} degrees in elevation and {:.2f} degrees in azimuth of "
      "their beams",
      median_degrees(errors.elevation), median_degrees(errors.azimuth));
  found.trust = misfit > kWrongMisfit ? Trust::wrong : found.size > 1 ? Trust::doubtful : Trust::right;
  if (found.trust == Trust::right) return found;
  const std::string mistakes = beam_mistakes(samples, model, given);
  found.problem = fmt::format(
      "half of the points are more than {:.1f} degrees in elevation and {:.1f} degrees in azimuth off the "
      "beams "
      "of {}",
      median_degrees(errors.elevation), median_degrees(errors.azimuth), model.name);
  if (misfit <= 1) {
    found.problem = fmt::format("the points of laser {} are {:.1f} times the tolerance off its beam",
                                worst.laser, worst.misfit);
  }
  if (!mistakes.empty()) found.problem += ": " + mistakes;
  found.remedy = "correct the description of the sensor, or the points";
  return found;
}

}  // namespace mapless
