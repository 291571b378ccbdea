#include "trajectory/domain.hpp"

#include <fmt/format.h>

#include "core/number_text.hpp"
#include "core/rotation_check.hpp"
#include "core/time_check.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Twice the circumference of the Earth and more: geocentric and map coordinates lie within.
constexpr double kFarthest_m = 1e8;

}  // namespace

void require_covered(Time t, Time begin, Time end, const std::string& source) {
  if (begin <= t && t <= end) return;
  throw TrajectoryDomainError(
      {source, "time", decimal_seconds(t) + " s",
       fmt::format("the trajectory covers {} s to {} s", decimal_seconds(begin), decimal_seconds(end)),
       "give a trajectory of the whole recording, choose fewer scans or allow more extrapolation"});
}

void require_period(Duration period) {
  if (period >= Duration()) return;
  throw ParameterError({"Trajectory::sample", "period", fmt::format("{} ns", period.nanoseconds()),
                        "is negative", "give a period of at least 0"});
}

void PoseChecks::add(Time t, const SE3& T_v0) {
  require_time(source_, fmt::format("time of {} {}", item_, count_), t);
  require_later(t);
  require_rigid(T_v0);
  require_near(T_v0);
  last_ = t;
  ++count_;
}

void PoseChecks::finish() const {
  if (count_ >= 2) return;
  throw InputError({source_, item_ + "s", fmt::format("{}", count_), "a trajectory needs at least two",
                    fmt::format("give a {} before and after the recording", item_)});
}

void PoseChecks::require_later(Time t) const {
  if (count_ == 0 || t > last_) return;
  throw InputError({source_, fmt::format("time of {} {}", item_, count_), decimal_seconds(t) + " s",
                    fmt::format("not after the {} before it at {} s", item_, decimal_seconds(last_)),
                    fmt::format("give every {} once, in order of time", item_)});
}

void PoseChecks::require_rigid(const SE3& T_v0) const {
  const auto problem = rotation_problem(T_v0.rotation());
  if (!problem) return;
  throw InputError({source_, fmt::format("rotation of {} {}", item_, count_), "", *problem,
                    "give an orthonormal matrix of determinant +1"});
}

void PoseChecks::require_near(const SE3& T_v0) const {
  const Eigen::Vector3d position = T_v0.inverse().translation();
  if (position.norm() <= kFarthest_m) return;  // false for NaN
  throw InputError({source_, fmt::format("position of {} {}", item_, count_),
                    fmt::format("{:g} {:g} {:g}", position.x(), position.y(), position.z()),
                    fmt::format("farther than {:g} m from the origin", kFarthest_m),
                    "give positions in metres, or leave the row out"});
}

}  // namespace mapless
