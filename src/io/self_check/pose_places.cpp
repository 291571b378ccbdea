#include "io/self_check/pose_places.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/median.hpp"

namespace mapless::inline v1 {
namespace {

// Poses jump where the change of velocity within a period displaces by this much, and by so many times the
// usual.
constexpr double kJump_m = 0.5, kJumpTimes = 8;
constexpr std::size_t kMostJumps = 2;

// The last scan half a second before scan k: their pair ends with k. Scan k where there is none.
std::size_t half_a_second_before(const Dataset& dataset, std::size_t k, std::size_t first) {
  std::size_t j = k;
  while (j > first && (dataset.scan_start(k) - dataset.scan_start(j)).seconds() < kPairApart_s) --j;
  return (dataset.scan_start(k) - dataset.scan_start(j)).seconds() < kPairApart_s ? k : j;
}

}  // namespace

std::size_t scans_apart(const Dataset& dataset, std::size_t k, std::size_t last) {
  std::size_t n = 1;
  while (k + n < last && (dataset.scan_start(k + n) - dataset.scan_start(k)).seconds() < kPairApart_s) ++n;
  return n;
}

std::vector<std::size_t> places_at_jumps(const Dataset& dataset, const Motion& said, std::size_t first,
                                         std::size_t count) {
  std::vector<SE3> poses;
  for (std::size_t k = first; k < first + count; ++k) {
    const auto pose = said(dataset.scan_start(k));
    if (!pose) return {};
    poses.push_back(*pose);
  }
  std::vector<std::pair<double, std::size_t>> sizes;
  std::vector<double> all;
  for (std::size_t i = 1; i + 1 < poses.size(); ++i) {
    const double before_s = (dataset.scan_start(first + i) - dataset.scan_start(first + i - 1)).seconds();
    const double after_s = (dataset.scan_start(first + i + 1) - dataset.scan_start(first + i)).seconds();
    if (!(before_s > 0 && after_s > 0)) continue;
    const SE3 before = poses[i - 1].inverse() * poses[i], after = poses[i].inverse() * poses[i + 1];
    const Vector6d change = after.log() * (before_s / after_s) - before.log();
    const double size = change.head<3>().norm() + kLever_m * change.tail<3>().norm();
    sizes.emplace_back(size, first + i);
    all.push_back(size);
  }
  if (all.empty()) return {};
  const double usual = median(all);
  std::sort(sizes.rbegin(), sizes.rend());
  std::vector<std::size_t> out;
  for (const auto& [size, k] : sizes) {
    if (size < std::max(kJump_m, kJumpTimes * usual) || out.size() == 2 * kMostJumps) break;
    const bool near =
        std::any_of(out.begin(), out.end(), [k = k](std::size_t o) { return o < k + 5 && k < o + 5; });
    if (near) continue;
    out.push_back(std::max(first + 2, k) - 2);
    out.push_back(half_a_second_before(dataset, k, first));
  }
  return out;
}

std::vector<std::size_t> within(const Dataset& dataset, std::size_t first, std::size_t last,
                                std::vector<std::size_t> numbers) {
  for (std::size_t& k : numbers) {
    while (k > first && (dataset.scan_start(last) - dataset.scan_start(k)).seconds() < kPairApart_s) --k;
    k = std::min(k, last - 1);
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

}  // namespace mapless
