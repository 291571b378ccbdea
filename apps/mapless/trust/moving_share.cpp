#include "trust/moving_share.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace mapless::app {
namespace {

// Rise of the share within one scan over that of the three scans before it. The most over 33 right recordings
// of 60 scans is 0.13 (something comes into the sight of a hovering sensor); 1 m off gives 0.2 and more.
constexpr double kRise = 0.17;
// The first scans of a run: their movers are found within a second.
constexpr std::size_t kStart = 8;
// Share over a whole run. A motorway has 0.1, and most 0.2 in a scan.
constexpr double kMost = 0.5;
// Scans of fewer points are not checked: the share of a few objects is large.
constexpr std::size_t kFewestPoints = 1000;

}  // namespace

void MovingShare::add(std::size_t k, std::size_t moving, std::size_t points) {
  if (points < kFewestPoints) return;
  const double share = static_cast<double>(moving) / static_cast<double>(points);
  const double usual = *std::max_element(before_.begin(), before_.end());
  if (scans_ >= kStart && share > usual + kRise && rises_++ == 0) {
    first_rise_ = k;
    rise_from_ = usual;
    rise_to_ = share;
  }
  before_[scans_++ % before_.size()] = share;
  moving_ += moving;
  points_ += points;
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

}  // namespace mapless::app
