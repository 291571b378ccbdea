#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>

#include "detection/freespace/four_lanes.hpp"
#include "detection/freespace/freespace_probe.hpp"

// The same source twice: four points at once for any processor, eight for one with vectors of 256 bits.

namespace mapless::inline v1 {
namespace {

// Iterations towards the column that observes a point; the points that need more are observed alone.
constexpr int kPasses = 4;
// Up to this angle [rad] the series of lane_numbers.inc is exact to 1e-6 rad: 0.15^9 / 9 is 4e-9.
constexpr float kSteadyAngle = 0.15F;
// Of atan(u), about u / (1 + 0.28 u^2) for |u| <= 1: the rational approximation errs by less than 0.005 rad.
constexpr float kArctanCoefficient = 0.28F;
// From here on a laser's place in the hub turns its beam by so little that its cosine is 1 within 2e-4.
constexpr float kFar_m = 2;
// Least cosine of a beam's elevation, with what a drift of the sensor changes: the height of a point above a
// beam is at least this share of their vertical distance.
constexpr float kSurely = 0.7F;
// A sensor that turns with 180 degrees per second does so by 0.5 degrees in the time of as many columns as
// two lasers are apart: to first order that errs by 4e-5 rad.
constexpr float kMaxLinearColumns = 120;

}  // namespace

template <int lanes>
struct LaneNumbers;  // `lanes` numbers side by side

}  // namespace mapless

#define MAPLESS_INLINE [[gnu::always_inline]] inline

#define MAPLESS_LANES 4
#include "detection/freespace/freespace_lanes.inc"
#undef MAPLESS_LANES

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAPLESS_EIGHT_LANES
#pragma GCC push_options
#pragma GCC target("avx2")
#define MAPLESS_LANES 8
#include "detection/freespace/freespace_lanes.inc"
#undef MAPLESS_LANES
#pragma GCC pop_options
#endif

#undef MAPLESS_INLINE

namespace mapless::inline v1 {

FreespaceProbe::Vectors FreespaceProbe::widest_vectors() {
#ifdef MAPLESS_EIGHT_LANES
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  return has_avx2 ? Vectors::of_eight : Vectors::of_four;
#else
  return Vectors::of_four;
#endif
}

void FreespaceProbe::observe(std::span<Points> points, std::span<Answers> answers,
                             [[maybe_unused]] Vectors vectors) const {
  if (image_.columns() == 0) {
    std::fill(answers.begin(), answers.end(), Answers{});
    return;
  }
#ifdef MAPLESS_EIGHT_LANES
  if (vectors == Vectors::of_eight) {
    Lanes<8>::observe(*this, points, answers);
    return;
  }
#endif
  Lanes<4>::observe(*this, points, answers);
}

FreespaceProbe::Answers FreespaceProbe::observe(Points& points, Vectors vectors) const {
  Answers answers;
  observe(std::span(&points, 1), std::span(&answers, 1), vectors);
  return answers;
}

}  // namespace mapless
