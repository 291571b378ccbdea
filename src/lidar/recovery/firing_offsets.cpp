#include "lidar/recovery/firing_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <tbb/parallel_for.h>

#include "lidar/recovery/ring_points.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kSeam_rad = std::numbers::pi;
// Offsets that are tried: HDL-64E has up to 9.9 degrees, OS1 4.2.
constexpr double kMostOffset_rad = 0.2;
// Apart: 1.4 degrees are 0.4 ms, in which 10 m/s are 4 mm, a sixth of the encoder's spacing (0.09 degrees) at
// 15 m.
constexpr int kTried = 17;
// The fullest rings show the number of the encoder's positions, each with an offset of its own.
constexpr std::size_t kRingsForPositions = 4;
// By chance concentrations differ by 1/sqrt(800) = 0.035.
constexpr double kGainOfOffset = 0.03;
// Offsets are tried on one point in so many: the concentration looks at 800 of a ring's 10,000.
constexpr std::size_t kStride = 8;

double tried(int i) { return kMostOffset_rad * (2.0 * i / (kTried - 1) - 1); }

std::vector<RingPoints> rings_with(const std::vector<CompensatedCloud>& clouds, std::size_t ring_count,
                                   double offset_rad) {
  std::vector<RingedCloud> measured;
  const std::vector<double> offsets(ring_count, offset_rad);
  for (const CompensatedCloud& c : clouds) measured.push_back({measured_points(c, offsets), c.cloud.rings});
  return collect_rings(measured, ring_count);
}

std::vector<CompensatedCloud> every(std::size_t stride, const std::vector<CompensatedCloud>& clouds) {
  std::vector<CompensatedCloud> out;
  for (const CompensatedCloud& from : clouds) {
    CompensatedCloud few{{}, from.T_vc};
    for (std::size_t i = 0; i < from.cloud.points.size(); i += stride) {
      few.cloud.points.push_back(from.cloud.points[i]);
      few.cloud.rings.push_back(from.cloud.rings[i]);
    }
    out.push_back(std::move(few));
  }
  return out;
}

// The number that most of the fullest rings show, each with the offset under which it is most concentrated;
// 0: none.
int grid_positions(const std::vector<std::vector<RingPoints>>& rings_of_tried, double spacing_rad) {
  const std::vector<RingPoints>& without = rings_of_tried[kTried / 2];
  std::vector<std::size_t> fullest(without.size());
  std::iota(fullest.begin(), fullest.end(), std::size_t{0});
  std::stable_sort(fullest.begin(), fullest.end(),
                   [&](std::size_t a, std::size_t b) { return without[a].size() > without[b].size(); });
  fullest.resize(std::min(fullest.size(), kRingsForPositions));
  std::vector<int> found(fullest.size(), 0);
  tbb::parallel_for(std::size_t{0}, fullest.size(), [&](std::size_t k) {
    double best = 0;
    for (const auto& rings : rings_of_tried) {
      const RingPoints& ring = rings[fullest[k]];
      const int positions = find_grid_positions({ring}, spacing_rad, kSeam_rad);
      if (positions == 0) continue;
      const double concentration = grid_concentration(ring, kSeam_rad, positions);
      if (concentration > best) found[k] = positions;
      best = std::max(best, concentration);
    }
  });
  std::map<int, int> rings_with_number;
  for (const int positions : found) ++rings_with_number[positions];
  const auto most = std::max_element(rings_with_number.begin(), rings_with_number.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most->first;
}

// The vertex of the parabola through the best value and its neighbours; 0 where none is concentrated, or none
// more than without an offset.
double best_offset(const std::vector<double>& concentration) {
  const auto best = std::max_element(concentration.begin(), concentration.end());
  if (*best < kConcentrated || *best < concentration[kTried / 2] + kGainOfOffset) return 0;
  const auto i = static_cast<int>(best - concentration.begin());
  if (i == 0 || i == kTried - 1) return tried(i);
  const double before = *(best - 1), after = *(best + 1), bend = before - 2 * *best + after;
  const double part = bend < 0 ? 0.5 * (before - after) / bend : 0;
  return tried(i) + part * (tried(1) - tried(0));
}

}  // namespace

std::vector<Eigen::Vector3f> measured_points(const CompensatedCloud& compensated,
                                             const std::vector<double>& offsets_rad) {
  // The compensation has changed the azimuth a little: a fixed-point iteration, each pass of which leaves
  // about a hundredth of the error.
  constexpr int kPasses = 3;
  const auto parts = static_cast<double>(compensated.T_vc.size());
  std::vector<Eigen::Vector3f> points = compensated.cloud.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int32_t ring = compensated.cloud.rings[i];
    if (ring < 0 || !is_usable(points[i])) continue;
    const double offset = offsets_rad[static_cast<std::size_t>(ring)];
    const Eigen::Vector3d p_c = points[i].cast<double>();
    Eigen::Vector3d p_v = p_c;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double hub = std::remainder(std::atan2(p_v.y(), p_v.x()) - offset, 2 * std::numbers::pi);
      const double turn = (1 - hub / std::numbers::pi) / 2;
      p_v = compensated.T_vc[static_cast<std::size_t>(std::clamp(turn * parts, 0.0, parts - 1))] * p_c;
    }
    points[i] = p_v.cast<float>();
  }
  return points;
}

std::optional<std::vector<double>> find_firing_offsets(const std::vector<CompensatedCloud>& clouds,
                                                       std::size_t ring_count) {
  const double spacing_rad = find_grid_spacing(rings_with(clouds, ring_count, 0));
  if (spacing_rad == 0) return std::nullopt;
  const std::vector<CompensatedCloud> few = every(kStride, clouds);
  std::vector<std::vector<RingPoints>> rings_of_tried(kTried);
  tbb::parallel_for(0, kTried, [&](int i) {
    rings_of_tried[static_cast<std::size_t>(i)] = rings_with(few, ring_count, tried(i));
  });
  const int positions = grid_positions(rings_of_tried, spacing_rad);
  if (positions == 0) return std::nullopt;
  std::vector<double> offsets(ring_count);
  tbb::parallel_for(std::size_t{0}, ring_count, [&](std::size_t r) {
    std::vector<double> concentration;
    for (const auto& rings : rings_of_tried)
      concentration.push_back(grid_concentration(rings[r], kSeam_rad, positions));
    offsets[r] = best_offset(concentration);
  });
  return offsets;
}

}  // namespace mapless
