#include "detection/range_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace mapless {
namespace {

// Stretches of so many firings, one in so many of a row, tell, if there are enough of them. The smoothest
// quarter is of walls and ground, also in a forest.
constexpr std::size_t kStretch = 16, kOneIn = 6, kFewestStretches = 50, kSmoothest = 4;

// Of Gaussian noise: the median of the second differences' sizes is .6745 sqrt(6) standard deviations.
constexpr double kDeviationsPerMedian = 1 / (0.6745 * 2.4495);

bool is_consecutive(const LidarReturn& first, const LidarReturn& last) {
  return first.laser == last.laser && last.column - first.column == static_cast<int>(kStretch) - 1;
}

float median_second_difference(const LidarReturn* r) {
  std::array<float, kStretch - 2> sizes;
  for (std::size_t k = 0; k < sizes.size(); ++k)
    sizes[k] = std::abs(r[k].range_m - 2 * r[k + 1].range_m + r[k + 2].range_m);
  std::nth_element(sizes.begin(), sizes.begin() + sizes.size() / 2, sizes.end());
  return sizes[sizes.size() / 2];
}

}  // namespace

double range_noise_m(const LidarScan& scan) {
  std::vector<float> medians;
  for (std::size_t i = 0; i + kStretch <= scan.returns.size(); i += kOneIn * kStretch) {
    if (is_consecutive(scan.returns[i], scan.returns[i + kStretch - 1]))
      medians.push_back(median_second_difference(&scan.returns[i]));
  }
  if (medians.size() < kFewestStretches) return 0;
  const auto quarter = medians.begin() + static_cast<std::ptrdiff_t>(medians.size() / kSmoothest);
  std::nth_element(medians.begin(), quarter, medians.end());
  return kDeviationsPerMedian * static_cast<double>(*quarter);
}

VotingParameters for_noise_of(const LidarScan& scan, VotingParameters parameters) {
  parameters.tolerance_m = std::max(parameters.tolerance_m, kToleratedDeviations * range_noise_m(scan));
  return parameters;
}

}  // namespace mapless
