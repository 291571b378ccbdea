#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "lidar/ring_points.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/lidar/model_estimation.hpp>

namespace mapless {
namespace {

using Cloud = std::vector<Eigen::Vector3f>;

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
  return best;
}

std::vector<RingPoints> collect_rings(const std::vector<Cloud>& clouds,
                                      const std::vector<std::vector<std::size_t>>& starts, std::size_t count,
                                      int& scans_used) {
  std::vector<RingPoints> rings(count);
  scans_used = 0;
  for (std::size_t s = 0; s < clouds.size(); ++s) {
    if (starts[s].size() != count) continue;
    for (std::size_t ring = 0; ring < count; ++ring) {
      const std::size_t end = ring + 1 < count ? starts[s][ring + 1] : clouds[s].size();
      for (std::size_t i = starts[s][ring]; i < end; ++i) {
        if (!is_usable(clouds[s][i])) continue;
        const Eigen::Vector3d p = clouds[s][i].cast<double>();
        rings[ring].push_back({std::atan2(p.y(), p.x()), std::hypot(p.x(), p.y()), p.z(), scans_used});
      }
    }
    ++scans_used;
  }
  return rings;
}

Laser make_laser(const RingLine& line, const RingAzimuth& azimuth) {
  Laser laser;
  laser.elevation_rad = line.elevation_rad;
  laser.azimuth_offset_rad = azimuth.offset_rad;
  laser.origin_h_m = {-azimuth.across_m * std::sin(azimuth.offset_rad),
                      azimuth.across_m * std::cos(azimuth.offset_rad), line.origin_z_m};
  return laser;
}

double azimuth_residual(const std::vector<Cloud>& clouds, const std::vector<std::vector<std::size_t>>& starts,
                        const EstimatedModel& estimated, const std::string& source) {
  double squares = 0;
  double points = 0;
  for (std::size_t s = 0; s < clouds.size(); ++s) {
    if (starts[s].size() != estimated.model.lasers.size()) continue;
    const auto lasers = recover_lasers(clouds[s], estimated.model, estimated.layout, source);
    const double rms = recover_firings(clouds[s], lasers, estimated.model, estimated.layout.encoder_steps)
                           .residual_columns_rms;
    squares += rms * rms * static_cast<double>(clouds[s].size());
    points += static_cast<double>(clouds[s].size());
  }
  return points > 0 ? std::sqrt(squares / points) : 0;
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

EstimatedModel estimate_model(const std::vector<Cloud>& clouds, const ModelEstimationOptions& options,
                              const std::string& source) {
  std::vector<std::vector<std::size_t>> starts;
  for (const Cloud& cloud : clouds) starts.push_back(ring_starts(cloud));
  const std::size_t count = ring_count(starts, options.expected_rings, source);
  EstimatedModel result;
  ModelEstimate& estimate = result.estimate;
  const std::vector<RingPoints> rings = collect_rings(clouds, starts, count, estimate.scans_used);
  const std::vector<RingLine> lines = fit_ring_lines(rings);
  const AzimuthGrid grid =
      find_azimuth_grid(rings, options.start_azimuth_rad, static_cast<double>(options.direction));
  if (grid.columns <= 0) {
    throw InputError({source, "azimuths", "", "no two neighbouring points to take the column step from",
                      "name the sensor"});
  }

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
  estimate.elevation_residual_m = ring_line_residual(rings, lines);
  estimate.azimuth_residual_columns = azimuth_residual(clouds, starts, result, source);
  return result;
}

}  // namespace mapless
