#pragma once

#include <cstddef>
#include <string>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Throws TrajectoryDomainError that names `source` and the three times unless begin <= t <= end.
void require_covered(Time t, Time begin, Time end, const std::string& source);

/// Throws ParameterError for a negative period.
void require_period(Duration period);

/// Checks the poses of a trajectory in order. `item` names one of them in messages: "pose" or "knot".
class PoseChecks {
 public:
  PoseChecks(std::string source, std::string item) : source_(std::move(source)), item_(std::move(item)) {}
  /// Throws InputError unless `t` is after the time before it, and the pose a rotation and a position within
  /// 1e8 m of the origin.
  void add(Time t, const SE3& T_v0);
  /// Throws InputError for fewer than two poses.
  void finish() const;

 private:
  void require_later(Time t) const;
  void require_rigid(const SE3& T_v0) const;
  void require_near(const SE3& T_v0) const;

  std::string source_;
  std::string item_;
  std::size_t count_ = 0;
  Time last_;
};

}  // namespace mapless
