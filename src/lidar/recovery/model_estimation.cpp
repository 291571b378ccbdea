#include "lidar/recovery/model_estimation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

using Cloud = std::vector<Eigen::Vector3f>;

// Twice as many as any sensor has lasers. The points of a cloud in another order fall into tens of thousands.
constexpr std::size_t kMostRings = 256;

// RMS distance of the points from the lines of their rings. Of KITTI raw 0.0003 m; of a cloud that is
// compensated for motion, several centimetres. Beams 0.4 degrees apart are 0.2 m apart at 30 m: then rings
// are none. Chosen.
constexpr double kLargestResidual_m = 0.2;

// The expected number of rings where any scan has it, else the most frequent one (the larger of two).
std::size_t ring_count(const std::vector<std::vector<std::size_t>>& starts, int expected,
                       const std::string& source) {
  std::map<std::size_t, int> scans_with;
  for (const auto& s : starts) ++scans_with[s.size()];
  scans_with.erase(0);
  if (scans_with.empty()) {
    throw InputError(
        {source, "rings", "0", "no usable points to find the sensor's rings in", "name the sensor"});
  }
  const auto known = scans_with.find(static_cast<std::size_t>(expected));
  if (known != scans_with.end()) return known->first;
  std::size_t best = 0;
  int most = 0;
  for (const auto& [rings, scans] : scans_with) {
    if (scans >= most) {
      best = rings;
      most = scans;
    }
  }
  if (best <= kMostRings) return best;
  throw InputError({source, "rings", std::to_string(best),
                    "more than " + std::to_string(kMostRings) + ": the points are not stored ring after ring",
                    "restore the order in which the sensor's driver wrote them"});
}

double checked_residual(double residual_m, std::size_t rings, const std::string& source) {
  if (residual_m <= kLargestResidual_m) return residual_m;
  throw InputError({source, "rings", fmt::format("{:.0f} mm", 1e3 * residual_m),
                    fmt::format("so far from {} beams (RMS) are the points that should lie on them: rings or "
                                "columns of the recording are not what they were taken for",
                                rings),
                    "name the sensor (--sensor), or say what the columns are; points must be in the frame of "
                    "the sensor, not of the world"});
}

Laser make_laser(const RingLine& line, const RingAzimuth& azimuth) {
  Laser laser;
  laser.elevation_rad = line.elevation_rad;
  laser.azimuth_offset_rad = azimuth.offset_rad;
  laser.origin_h_m = {-azimuth.across_m * std::sin(azimuth.offset_rad),
                      azimuth.across_m * std::cos(azimuth.offset_rad), line.origin_z_m};
  return laser;
}

// Of the offsets that are possible by the grid, those nearest to the ones known roughly.
void take_nearest(const std::vector<double>& near_rad, AzimuthGrid& grid) {
  const double column = 2 * std::numbers::pi / grid.columns;
  for (std::size_t i = 0; i < grid.rings.size(); ++i) {
    RingAzimuth& ring = grid.rings[i];
    if (ring.known) {
      ring.offset_rad += column * std::round((near_rad[i] - ring.offset_rad) / column);
    } else {
      ring.offset_rad = near_rad[i];
    }
  }
}

double azimuth_residual(const std::vector<RingedCloud>& clouds, const EstimatedModel& estimated) {
  double squares = 0;
  double count = 0;
  for (const RingedCloud& cloud : clouds) {
    Cloud points;
    std::vector<std::int32_t> lasers;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (cloud.rings[i] < 0) continue;
      points.push_back(cloud.points[i]);
      lasers.push_back(estimated.layout.row_of_ring[static_cast<std::size_t>(cloud.rings[i])]);
    }
    const double rms =
        recover_firings(points, lasers, estimated.model, estimated.layout.encoder_steps).residual_columns_rms;
    squares += rms * rms * static_cast<double>(points.size());
    count += static_cast<double>(points.size());
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

LidarModel model_without_lasers(const ModelEstimationOptions& options, int columns) {
  LidarModel model;
  model.name = options.name;
  model.rotation_rate_hz = options.rotation_rate_hz;
  model.direction = options.direction;
  model.columns = columns;
  model.start_azimuth_rad = options.start_azimuth_rad;
  model.min_range_m = options.min_range_m;
  model.max_range_m = options.max_range_m;
  return model;
}

}  // namespace

RingedClouds find_rings(const std::vector<Cloud>& clouds, int expected_rings, const std::string& source) {
  std::vector<std::vector<std::size_t>> starts;
  for (const Cloud& cloud : clouds) starts.push_back(ring_starts(cloud));
  RingedClouds found;
  found.ring_count = ring_count(starts, expected_rings, source);
  for (std::size_t s = 0; s < clouds.size(); ++s) {
    if (starts[s].size() != found.ring_count) continue;
    RingedCloud cloud{clouds[s], std::vector<std::int32_t>(clouds[s].size(), 0)};
    for (std::size_t ring = 0; ring < found.ring_count; ++ring) {
      std::fill(cloud.rings.begin() + static_cast<std::ptrdiff_t>(starts[s][ring]), cloud.rings.end(),
                static_cast<std::int32_t>(ring));
    }
    found.clouds.push_back(std::move(cloud));
    found.numbers.push_back(s);
  }
  return found;
}

std::vector<RingPoints> collect_rings(const std::vector<RingedCloud>& clouds, std::size_t count) {
  std::vector<RingPoints> rings(count);
  int scan = 0;
  for (const RingedCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (cloud.rings[i] < 0 || !is_usable(cloud.points[i])) continue;
      const Eigen::Vector3d p = cloud.points[i].cast<double>();
      rings[static_cast<std::size_t>(cloud.rings[i])].push_back(
          {std::atan2(p.y(), p.x()), std::hypot(p.x(), p.y()), p.z(), scan});
    }
    ++scan;
  }
  return rings;
}

EstimatedModel estimate_model(const std::vector<Cloud>& clouds, const ModelEstimationOptions& options,
                              const std::string& source) {
  const RingedClouds found = find_rings(clouds, options.expected_rings, source);
  return estimate_model_of_rings(found.clouds, found.ring_count, options, source);
}

EstimatedModel estimate_model_of_rings(const std::vector<RingedCloud>& clouds, std::size_t count,
                                       const ModelEstimationOptions& options, const std::string& source) {
  EstimatedModel result;
  ModelEstimate& estimate = result.estimate;
  estimate.scans_used = static_cast<int>(clouds.size());
  const std::vector<RingPoints> rings = collect_rings(clouds, count);
  const std::vector<RingLine> lines = fit_ring_lines(rings);
  estimate.elevation_residual_m = checked_residual(ring_line_residual(rings, lines), count, source);
  AzimuthGrid grid =
      find_azimuth_grid(rings, options.start_azimuth_rad, static_cast<double>(options.direction));
  if (grid.columns <= 0) {
    throw InputError({source, "azimuths", "", "no two neighbouring points to take the column step from",
                      "name the sensor"});
  }
  if (!grid.absolute && !options.offsets_near_rad.empty()) take_nearest(options.offsets_near_rad, grid);

  std::vector<int> ring_of_row(count);
  std::iota(ring_of_row.begin(), ring_of_row.end(), 0);
  std::stable_sort(ring_of_row.begin(), ring_of_row.end(), [&](int a, int b) {
    return lines[static_cast<std::size_t>(a)].elevation_rad <
           lines[static_cast<std::size_t>(b)].elevation_rad;
  });
  result.model = model_without_lasers(options, grid.columns);
  result.layout.encoder_steps = grid.encoder_steps;
  result.layout.row_of_ring.resize(count);
  for (std::size_t row = 0; row < count; ++row) {
    const auto ring = static_cast<std::size_t>(ring_of_row[row]);
    result.layout.row_of_ring[ring] = static_cast<int>(row);
    result.model.lasers.push_back(make_laser(lines[ring], grid.rings[ring]));
    estimate.lasers_borrowed += lines[ring].borrowed ? 1 : 0;
    estimate.azimuths_known += grid.rings[ring].known ? 1 : 0;
  }
  estimate.encoder_steps = grid.encoder_steps;
  estimate.azimuths_absolute = grid.absolute;
  estimate.azimuth_residual_columns = azimuth_residual(clouds, result);
  return result;
}

}  // namespace mapless
