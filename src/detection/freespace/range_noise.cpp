#include "detection/freespace/range_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "detection/freespace/four_lanes.hpp"

namespace mapless::inline v1 {
namespace {

// Stretches of 16 consecutive firings, one in six of all, have one estimate each; below 50 stretches there is
// no estimate. Its median over the smoothest quarter counts: walls and ground, also in a forest. Chosen: one
// in six keeps the estimate cheap.
constexpr std::size_t kStretch = 16, kOneIn = 6, kMinStretches = 50, kSmoothestShare = 4;

// The median magnitude of the second differences of Gaussian noise is .6745 sqrt(1 + 4 + 1) standard
// deviations.
constexpr double kDeviationsPerMedian = 1 / (0.6745 * 2.4495);

bool is_consecutive(const LidarReturn& first, const LidarReturn& last) {
  return first.laser == last.laser && last.column - first.column == static_cast<int>(kStretch) - 1;
}

// Of four stretches side by side: their sizes are sorted by exchanges of neighbours, which are the same for
// all.
std::array<float, 4> median_second_differences(const std::array<const LidarReturn*, 4>& stretches) {
  const auto range = [&](std::size_t k) {
    return Floats{stretches[0][k].range_m, stretches[1][k].range_m, stretches[2][k].range_m,
                  stretches[3][k].range_m};
  };
  std::array<Floats, kStretch - 2> sizes;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const Floats difference = range(k) - 2 * range(k + 1) + range(k + 2);
    sizes[k] = difference < 0 ? -difference : difference;
  }
  for (std::size_t round = 0; round < sizes.size(); ++round) {
    for (std::size_t k = round % 2; k + 1 < sizes.size(); k += 2) {
      const Floats a = sizes[k], b = sizes[k + 1];
      sizes[k] = a < b ? a : b;
      sizes[k + 1] = a < b ? b : a;
    }
  }
  const Floats medians = sizes[sizes.size() / 2];
  return {medians[0], medians[1], medians[2], medians[3]};
}

std::vector<const LidarReturn*> stretches_of(const LidarScan& scan) {
  std::vector<const LidarReturn*> stretches;
  stretches.reserve(scan.returns.size() / (kOneIn * kStretch) + 1);
  for (std::size_t i = 0; i + kStretch <= scan.returns.size(); i += kOneIn * kStretch) {
    if (is_consecutive(scan.returns[i], scan.returns[i + kStretch - 1]))
      stretches.push_back(&scan.returns[i]);
  }
  return stretches;
}

}  // namespace

double range_noise_m(const LidarScan& scan) {
  const std::vector<const LidarReturn*> stretches = stretches_of(scan);
  if (stretches.size() < kMinStretches) return 0;
  std::vector<float> medians(stretches.size());
  for (std::size_t first = 0; first < stretches.size(); first += 4) {
    std::array<const LidarReturn*, 4> four;  // the last one again where there are fewer
    for (std::size_t k = 0; k < four.size(); ++k)
      four[k] = stretches[std::min(first + k, stretches.size() - 1)];
    const std::array<float, 4> found = median_second_differences(four);
    std::copy_n(found.begin(), std::min(four.size(), stretches.size() - first),
                medians.begin() + static_cast<std::ptrdiff_t>(first));
  }
  const auto quarter = medians.begin() + static_cast<std::ptrdiff_t>(medians.size() / kSmoothestShare);
  std::nth_element(medians.begin(), quarter, medians.end());
  return kDeviationsPerMedian * static_cast<double>(*quarter);
}

VotingParameters with_tolerance_for_noise(VotingParameters parameters, const LidarScan& scan) {
  parameters.tolerance_m = std::max(parameters.tolerance_m, kToleratedDeviations * range_noise_m(scan));
  return parameters;
}

}  // namespace mapless
