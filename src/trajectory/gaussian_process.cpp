#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "trajectory/domain.hpp"
#include "trajectory/knot_states.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {
namespace {

Time instant(Time first, Duration period, std::size_t i) {
  return first + Duration::from_nanoseconds(static_cast<std::int64_t>(i) * period.nanoseconds());
}

// Index of the knot at the end of the segment that t lies in.
std::size_t second_knot(std::span<const TrajectoryKnot> knots, Time t) {
  const auto second =
      std::upper_bound(knots.begin() + 1, knots.end() - 1, t,
                       [](Time time, const TrajectoryKnot& knot) { return time < knot.time; });
  return static_cast<std::size_t>(second - knots.begin());
}

}  // namespace

void Trajectory::sample(Time first, Duration period, std::span<TrajectoryState> states) const {
  require_period(period);
  for (std::size_t i = 0; i < states.size(); ++i) states[i] = at(instant(first, period, i));
}

// Anderson and Barfoot, IROS 2015; method.md section 3. In the coordinates gamma(t) = ln(T(t) T_1^-1) the
// posterior mean is the cubic through both ends with their velocities: its coefficients do not depend on Qc.
KnotSegment::KnotSegment(const TrajectoryKnot& k1, const TrajectoryKnot& k2)
    : k1_(k1),
      dt_((k2.time - k1.time).seconds()),
      xi_((k2.T_v0 * k1.T_v0.inverse()).log()),
      velocity_2_(left_jacobian_inverse(xi_) * k2.varpi) {
  if (k1.time < k2.time) return;
  throw ParameterError({"KnotSegment", "k2.time", fmt::format("{} ns", k2.time.nanoseconds()),
                        fmt::format("not after k1.time = {} ns", k1.time.nanoseconds()),
                        "give two knots in order of time"});
}

TrajectoryState KnotSegment::at(Time t) const {
  const double r = (t - k1_.time).seconds() / dt_;
  const double r2 = r * r;
  const double r3 = r2 * r;
  const Vector6d gamma =
      dt_ * (r - 2 * r2 + r3) * k1_.varpi + (3 * r2 - 2 * r3) * xi_ + dt_ * (r3 - r2) * velocity_2_;
  const Vector6d gamma_dot =
      (1 - 4 * r + 3 * r2) * k1_.varpi + 6 * (r - r2) / dt_ * xi_ + (3 * r2 - 2 * r) * velocity_2_;
  return {SE3::exp(gamma) * k1_.T_v0, left_jacobian_times(gamma, gamma_dot)};
}

TrajectoryState interpolate(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Time t) {
  return KnotSegment(k1, k2).at(t);
}

TrajectoryState state_between(std::span<const TrajectoryKnot> knots, Time t, const std::string& source) {
  require_covered(t, knots.front().time, knots.back().time, source);
  const std::size_t second = second_knot(knots, t);
  return interpolate(knots[second - 1], knots[second], t);
}

void sample_between(std::span<const TrajectoryKnot> knots, Time first, Duration period,
                    const std::string& source, std::span<TrajectoryState> states) {
  require_period(period);
  std::size_t second = 0;
  std::optional<KnotSegment> segment;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Time t = instant(first, period, i);
    require_covered(t, knots.front().time, knots.back().time, source);
    if (const std::size_t now = second_knot(knots, t); now != second) {
      segment.emplace(knots[now - 1], knots[now]);
      second = now;
    }
    states[i] = segment->at(t);
  }
}

GaussianProcessTrajectory::GaussianProcessTrajectory(std::vector<TrajectoryKnot> knots, std::string source)
    : knots_(std::move(knots)), source_(std::move(source)) {
  PoseChecks checks(source_, "knot");
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    checks.add(knots_[i].time, knots_[i].T_v0);
    if (knots_[i].varpi.allFinite()) continue;
    throw InputError({source_, fmt::format("velocity of knot {}", i), "", "is not finite",
                      "give a velocity for every knot"});
  }
  checks.finish();
}

TrajectoryState GaussianProcessTrajectory::at(Time t) const { return state_between(knots_, t, source_); }

void GaussianProcessTrajectory::sample(Time first, Duration period, std::span<TrajectoryState> states) const {
  sample_between(knots_, first, period, source_, states);
}

}  // namespace mapless
