#include <limits>
#include <numbers>

#include "detection/four_lanes.hpp"
#include <mapless/detection/ray_image.hpp>

// FreespaceProbe::look for four points side by side. Far from the sensor and away from the seam all points
// take the same steps, so that they can share each instruction; a point that needs others asks by itself.

namespace mapless {
namespace {

constexpr int kPasses = 4;  // towards the column that looks at a point
constexpr float kSteadyAngle = 0.15F;
// From here on a laser's place in the hub turns its beam by so little that its cosine is 1 within 2e-4.
constexpr float kFar_m = 2;
// The cosine of a beam, and what a drift of the sensor changes, at the least.
constexpr float kSurely = 0.7F;
// A sensor that turns with 180 degrees per second does so by 0.5 degrees in the time of as many columns as
// two lasers are apart: to first order that errs by 4e-5 rad.
constexpr float kMostColumnsAside = 120;

// atan2(y, x): exact to 1e-6 rad where it is below 0.15, else to 0.01 rad, to look again nearer by.
Floats angle(Floats y, Floats x) {
  const Floats t = y / x;
  const Floats t2 = t * t;
  const Floats small = t * (1 - t2 * (1 / 3.0F - t2 * (1 / 5.0F - t2 / 7.0F)));
  const Ints is_small = (magnitude(y) < kSteadyAngle * x);
  if (all(is_small)) return small;
  const Ints steep = magnitude(y) > magnitude(x);
  const Floats u = steep ? -x / y : t;
  const Floats rest = u / (1 + 0.28F * u * u);
  const Floats half = Floats{} + std::numbers::pi_v<float> / 2;
  const Floats behind = y < 0 ? -2 * half : 2 * half;
  const Floats wide = steep ? (y < 0 ? rest - half : rest + half) : x < 0 ? rest + behind : rest;
  return is_small ? small : wide;
}

}  // namespace

struct FreespaceProbe::Lanes {
  using Beams = std::array<const Beam*, 4>;

  Lanes(const FreespaceProbe& asked, const std::array<Eigen::Vector3f, 4>& points) : probe(asked), q(points) {
    for (Eigen::Vector3f& p : q) p += probe.origin_;
  }
  const FreespaceProbe& probe;
  std::array<Eigen::Vector3f, 4> q;  // about the image's origin
  Ints fine{};                       // the lanes that can go on together
  // The points as the hub has them at column `at`, when it looks their way; exactly so at `column`.
  Ints at{};
  Floats column{}, x{}, y{}, z{}, horizontal{}, columns_per_m{};
  // How they drift from one column to the next [m, columns].
  Floats drift_ahead{}, drift_up{}, drift_columns{};

  struct Side {  // the nearest beams above the points, or below
    Beams beams{};
    Floats height{};  // of the points above them
    Floats range{}, spacing{};
    Ints found{}, column{};
  };
  struct Window {
    Ints border{}, hides{};
  };

  [[gnu::always_inline]] inline void find_columns();
  [[gnu::always_inline]] inline void follow();
  [[gnu::always_inline]] inline Floats slopes_in(const Bank& bank) const;
  [[gnu::always_inline]] inline std::size_t first_bank() const;
  [[gnu::always_inline]] inline void bracket(Side& below, Side& above);
  [[gnu::always_inline]] inline Floats heights_over(const Beams& beams) const;
  [[gnu::always_inline]] inline void sight(Side& side);
  void sight_alone(Ints near, Side& side);
  [[gnu::always_inline]] inline Floats look_around(const Side& side, Window& window) const;
  [[gnu::always_inline]] inline std::array<Answer, 4> judge(const Side& below, const Side& above) const;
};

// Poses of every few columns will do, and stay at hand.
void FreespaceProbe::Lanes::find_columns() {
  const auto last = static_cast<float>(probe.image_.columns() - 1);
  const float turn = std::abs(probe.fan_.columns_per_rad) * 2 * std::numbers::pi_v<float>;
  const auto stride = static_cast<float>(probe.pose_stride_);
  const float per_stride = 1 / stride;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Floats nearest = to_floats(truncated(clamped(column, 0, last) * per_stride + 0.5F)) * stride;
    at = truncated(nearest > last ? nearest - stride : nearest);
    std::array<Eigen::Vector4f, 4> q_h;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Matrix4f& T_h0 = probe.image_.pose(at[k]).T_h0;
      q_h[k] = T_h0.col(0) * q[k].x() + T_h0.col(1) * q[k].y() + (T_h0.col(2) * q[k].z() + T_h0.col(3));
    }
    x = Floats{q_h[0].x(), q_h[1].x(), q_h[2].x(), q_h[3].x()};
    y = Floats{q_h[0].y(), q_h[1].y(), q_h[2].y(), q_h[3].y()};
    z = Floats{q_h[0].z(), q_h[1].z(), q_h[2].z(), q_h[3].z()};
    const Floats off = angle(y, x) * probe.fan_.columns_per_rad;
    column = to_floats(at) + off;
    const Ints within = (column >= -0.5F) & (column < last + 0.5F);
    fine = (x >= kFar_m) & (magnitude(off) < stride) & within;
    if (all(fine)) return;
    column = within ? column : column < 0 ? column + turn : column - turn;
  }
}

void FreespaceProbe::Lanes::follow() {
  std::array<const Pose*, 4> poses{};
  for (std::size_t k = 0; k < 4; ++k) poses[k] = &probe.image_.pose(at[k]);
  const auto linear = members(poses, offsetof(Pose, linear));
  const auto angular = members(poses, offsetof(Pose, angular));
  const Floats t = y / x;
  horizontal = x * (1 + t * t / 2);  // t is below 0.01
  columns_per_m = probe.fan_.columns_per_rad / horizontal;
  drift_ahead = linear[0] + angular[1] * z - angular[2] * y;
  drift_columns = (linear[1] + angular[2] * x - angular[0] * z) * columns_per_m;
  drift_up = linear[2] + angular[0] * y - angular[1] * x;
}

Floats FreespaceProbe::Lanes::heights_over(const Beams& beams) const {
  const auto [cosine, sine, ahead_m, left_m] = members(beams, offsetof(Beam, cosine));
  const auto [up_m, offset_columns, spacing, unused] = members(beams, offsetof(Beam, up_m));
  const Floats passed = column - to_floats(at) + offset_columns - left_m * columns_per_m;
  const Floats ahead = horizontal + passed * drift_ahead - ahead_m;
  const Floats up = z + passed * drift_up - up_m;
  return cosine * up - sine * ahead;
}

Floats FreespaceProbe::Lanes::slopes_in(const Bank& bank) const {
  return (z - bank.centre_z_m) / (horizontal - bank.centre_x_m);
}

// The bank whose beams are about the points, mostly.
std::size_t FreespaceProbe::Lanes::first_bank() const {
  const auto& banks = probe.fan_.banks;
  for (std::size_t b = 0; b + 1 < banks.size(); ++b) {
    const float slope = (z[0] - banks[b].centre_z_m) / (horizontal[0] - banks[b].centre_x_m);
    if (slope >= banks[b].slopes.front() && slope <= banks[b].slopes[banks[b].slopes.size() - 2]) return b;
  }
  return banks.size() - 1;
}

// In each bank that can have nearer ones the first beams above and below; where they are not on their sides
// after all, near the sensor, the lane is not fine.
void FreespaceProbe::Lanes::bracket(Side& below, Side& above) {
  below.height += std::numeric_limits<float>::infinity();
  above.height -= std::numeric_limits<float>::infinity();
  for (std::size_t n = 0, b = first_bank(); n < probe.fan_.banks.size();
       ++n, b = b + 1 < probe.fan_.banks.size() ? b + 1 : 0) {
    const Bank& bank = probe.fan_.banks[b];
    const Floats slope = slopes_in(bank);
    const Floats under_all = (bank.slopes.front() - slope) * horizontal;
    const Floats over_all = (slope - bank.slopes[bank.slopes.size() - 2]) * horizontal;
    if (all((kSurely * under_all > -above.height) | (kSurely * over_all > below.height))) continue;
    const Ints step = truncated(clamped((slope - bank.slopes.front()) * bank.steps_per_slope, 0,
                                        static_cast<float>(bank.at_least.size() - 1)));
    Ints first{};
    for (std::size_t k = 0; k < 4; ++k) {
      const int surely = bank.at_least[static_cast<std::size_t>(step[k])];
      first[k] = surely + (bank.slopes[static_cast<std::size_t>(surely)] < slope[k] ? 1 : 0);
    }
    Beams lower{}, upper{};
    Floats over{}, under{};
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < 4; ++k) {
        lower[k] = &bank.beams[static_cast<std::size_t>(first[k])];
        upper[k] = lower[k] + 1;
      }
      over = heights_over(lower);
      under = heights_over(upper);
      const Ints step_up = under >= 0, step_down = over < 0;
      if (none(step_up | step_down)) break;
      first += step_down - step_up;
    }
    fine &= (over >= 0) & (under < 0);
    const Ints nearer_below = over < below.height;
    const Ints nearer_above = under > above.height;
    below.height = smaller(over, below.height);
    above.height = larger(under, above.height);
    for (std::size_t k = 0; k < 4; ++k) {
      below.beams[k] = nearer_below[k] != 0 || below.beams[k] == nullptr ? lower[k] : below.beams[k];
      above.beams[k] = nearer_above[k] != 0 || above.beams[k] == nullptr ? upper[k] : above.beams[k];
    }
  }
}

void FreespaceProbe::Lanes::sight(Side& side) {
  const auto [cosine, sine, ahead_m, left_m] = members(side.beams, offsetof(Beam, cosine));
  const auto [up_m, offset_columns, spacing, unused] = members(side.beams, offsetof(Beam, up_m));
  const Floats aside = offset_columns - left_m * columns_per_m;
  const Floats pointing = column + aside + aside * drift_columns;
  const auto last = static_cast<float>(probe.image_.columns() - 1);
  const Ints near = (pointing >= -0.5F) & (pointing < last + 0.5F) & (magnitude(aside) <= kMostColumnsAside);
  side.column = truncated(clamped(pointing, 0, last) + 0.5F);
  const Floats passed = to_floats(side.column - at);
  const Floats ahead = horizontal + passed * drift_ahead - ahead_m;
  const Floats up = z + passed * drift_up - up_m;
  side.range = cosine * ahead + sine * up;
  side.height = cosine * up - sine * ahead;
  side.spacing = spacing;
  const Beams& b = side.beams;
  side.found = Ints{b[0]->laser, b[1]->laser, b[2]->laser, b[3]->laser} >= 0;
  if (!all(near | ~side.found | ~fine)) sight_alone(near, side);
}

// The firings at the other end of the scan, and those too long before or after for a motion to first order.
void FreespaceProbe::Lanes::sight_alone(Ints near, Side& side) {
  for (std::size_t k = 0; k < 4; ++k) {
    if (near[k] != 0 || side.found[k] == 0 || fine[k] == 0) continue;
    const Sighting s = probe.sight(q[k], *side.beams[k], column[k], columns_per_m[k]);
    if (!s.found() || (s.height_m < 0) != (side.height[k] < 0)) {
      fine[k] = 0;
      continue;
    }
    side.column[k] = s.column;
    side.range[k] = s.range_m;
    side.height[k] = s.height_m;
  }
}

// What the firings nearest to the points have as their ranges.
Floats FreespaceProbe::Lanes::look_around(const Side& side, Window& window) const {
  std::array<const float*, 4> cells{};
  for (std::size_t k = 0; k < 4; ++k) {
    const bool usable = fine[k] != 0 && side.found[k] != 0;
    cells[k] = usable ? probe.image_.row_m(side.beams[k]->laser) + side.column[k] : probe.image_.row_m(0);
  }
  Floats shortest = Floats{} + std::numeric_limits<float>::infinity();
  Floats least_off = shortest;
  for (int c = -probe.half_window_; c <= probe.half_window_; ++c) {  // NaN is never smaller
    const Floats range = {cells[0][c], cells[1][c], cells[2][c], cells[3][c]};
    shortest = smaller(range, shortest);
    least_off = smaller(magnitude(range - side.range), least_off);
  }
  const Floats tolerance = probe.tolerance_at_0_m_ + probe.tolerance_spacings_ * side.spacing * side.range;
  window.border |= side.found & (least_off <= tolerance);
  window.hides |= side.found & (shortest < side.range - tolerance);
  return Floats{cells[0][0], cells[1][0], cells[2][0], cells[3][0]};
}

std::array<FreespaceProbe::Answer, 4> FreespaceProbe::Lanes::judge(const Side& below,
                                                                   const Side& above) const {
  Window window;
  const Floats range_below = look_around(below, window);
  const Floats range_above = look_around(above, window);
  const Ints is_above = above.found & (~below.found | (-above.height < below.height));
  const Floats range = is_above ? range_above : range_below;
  const Floats expected = is_above ? above.range : below.range;
  const Floats height = is_above ? above.height : below.height;
  const Floats spacing = is_above ? above.spacing : below.spacing;
  const Ints column_there = is_above ? above.column : below.column;
  const Ints reached =
      (above.found | below.found) &
      (magnitude(height) <= probe.reach_at_0_m_ + probe.reach_spacings_ * spacing * expected);
  const auto all_lanes = [](FreespaceVerdict v) { return Ints{} + static_cast<int>(v); };
  Ints verdict = all_lanes(FreespaceVerdict::inside);
  if (probe.fan_.beams.size() > 1) {
    const Ints known =
        (above.found & below.found) | (magnitude(height) <= kEdgeSpacings * spacing * expected);
    verdict = known ? verdict : all_lanes(FreespaceVerdict::unobserved);
  }
  verdict = window.hides ? all_lanes(FreespaceVerdict::unobserved) : verdict;
  verdict = range < expected ? all_lanes(FreespaceVerdict::outside) : verdict;
  verdict = range != range ? all_lanes(FreespaceVerdict::unobserved) : verdict;
  verdict = window.border ? all_lanes(FreespaceVerdict::border) : verdict;
  std::array<Answer, 4> answers;
  for (std::size_t k = 0; k < 4; ++k) {
    if (reached[k] == 0) continue;
    const Beam& beam = is_above[k] != 0 ? *above.beams[k] : *below.beams[k];
    answers[k] = {static_cast<FreespaceVerdict>(verdict[k]), beam.laser, column_there[k],
                  expected[k] - range[k]};
  }
  return answers;
}

std::array<FreespaceProbe::Answer, 4> FreespaceProbe::look(const std::array<Eigen::Vector3f, 4>& q,
                                                           std::array<float, 4>& columns) const {
  if (image_.columns() == 0) return {};
  Lanes lanes(*this, q);
  lanes.column = Floats{columns[0], columns[1], columns[2], columns[3]};
  lanes.find_columns();
  lanes.follow();
  Lanes::Side below, above;
  lanes.bracket(below, above);
  lanes.sight(below);
  lanes.sight(above);
  std::array<Answer, 4> answers = lanes.judge(below, above);
  for (std::size_t k = 0; k < 4; ++k) {
    if (lanes.fine[k] != 0) {
      columns[k] = lanes.column[k];
    } else {
      answers[k] = look(q[k], columns[k]);
    }
  }
  return answers;
}

}  // namespace mapless
