#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "core/half_turns.hpp"
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {
namespace {

// Rise of the share within one scan over that of the three scans before it: of the whole turn, and of every
// half turn. A vehicle beside the sensor fills half of the view at most; a step of the world shows all
// around. Measured: right recordings of 60 scans rise by .32 and .003 (a lorry that passes), or by .06 and
// .12 (a motorway), or by .11 and .02; two scans exchanged give .18 and .16, a jump of 1 m .3 to .6 and .2
// to .5.
constexpr double kRise = 0.12, kRiseEverywhere = 0.08;
// The first scans of a run: their movers are found within a second.
constexpr std::size_t kStart = 8;
// Share over a whole run. A motorway has 0.1, and most 0.2 in a scan.
constexpr double kMost = 0.5;
// Scans of fewer points are not checked: the share of a few objects is large.
constexpr std::size_t kFewestPoints = 1000;

}  // namespace

void MovingShare::add(std::size_t k, const Detection& detection) {
  const LidarScan& scan = *detection.scan;
  Sectors moving{}, points{};
  std::vector<std::uint8_t> sectors(static_cast<std::size_t>(std::max(1, scan.columns)));
  for (std::size_t c = 0; c < sectors.size(); ++c)
    sectors[c] = static_cast<std::uint8_t>(kSectors * c / sectors.size());
  for (std::size_t i = 0; i < detection.object.size(); ++i) {
    const std::size_t sector = sectors[static_cast<std::size_t>(scan.returns[i].column)];
    ++points[sector];
    if (detection.object[i] != 0) ++moving[sector];
  }
  add(k, moving, points);
}

MovingShare::Shares MovingShare::shares_of(const Sectors& moving, const Sectors& points) {
  const auto share = [](std::size_t m, std::size_t n) {
    return n > 0 ? static_cast<double>(m) / static_cast<double>(n) : 0;
  };
  const Sectors moving_halves = half_turns(moving), halves = half_turns(points);
  // Any two opposite half turns are the whole.
  Shares out{share(moving_halves[0] + moving_halves[kSectors / 2], halves[0] + halves[kSectors / 2]), 1};
  for (std::size_t i = 0; i < kSectors; ++i)
    out.least_half = std::min(out.least_half, share(moving_halves[i], halves[i]));
  return out;
}

void MovingShare::add(std::size_t k, const Sectors& moving, const Sectors& points) {
  const std::size_t all = std::accumulate(points.begin(), points.end(), std::size_t{0});
  if (all < kFewestPoints) return;
  const Shares now = shares_of(moving, points);
  Shares usual;
  for (const Shares& before : before_) {
    usual.all = std::max(usual.all, before.all);
    usual.least_half = std::max(usual.least_half, before.least_half);
  }
  const bool rises = now.all > usual.all + kRise && now.least_half > usual.least_half + kRiseEverywhere;
  if (scans_ >= kStart && rises && rises_++ == 0) {
    first_rise_ = k;
    rise_from_ = usual.all;
    rise_to_ = now.all;
  }
  before_[scans_++ % before_.size()] = now;
  moving_ += std::accumulate(moving.begin(), moving.end(), std::size_t{0});
  points_ += all;
}

std::string MovingShare::trouble() const {
  const double share = points_ > 0 ? static_cast<double>(moving_) / static_cast<double>(points_) : 0;
  if (rises_ > 0) {
    return fmt::format(
        "the share of points called moving rises from {:.0f} to {:.0f} % at once in scan {}{}: a "
        "jump of the poses, or scans that are not in their order?",
        100 * rise_from_, 100 * rise_to_, first_rise_,
        rises_ > 1 ? fmt::format(" and {} others", rises_ - 1) : "");
  }
  if (scans_ > kStart && share > kMost)
    return fmt::format("{:.0f} % of all points are called moving: wrong poses?", 100 * share);
  return "";
}

}  // namespace mapless
