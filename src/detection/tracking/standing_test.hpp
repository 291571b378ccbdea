#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/detection_pipeline.hpp"
#include "detection/freespace/freespace_probe.hpp"
#include "detection/tracking/slow_motion.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Asks which of two hypotheses explains the rays of the scans around: that an object stands, or that it
/// moves with the velocity of its track. A hypothesis says where each point of the object was at the time of
/// a scan. It explains a ray that passes there if the ray ended on a surface there; not if the ray went on,
/// nor if something hid the place. Rays that end on the same surface again and again say that it stands,
/// whatever the registration of its visible part claims.
class StandingTest {
 public:
  /// Keeps references. `points` are those of `scan`, `references` the scans that gave their evidence, of the
  /// earlier ones the nearest first.
  StandingTest(const LidarScan& scan, const LocalPoints& points, std::span<const ReferenceRays> references,
               const VotingParameters& parameters);

  /// Whether the object of these returns of the scan stands. Where the scans beside it fix the velocity of
  /// its surface, that replaces `velocity_0`, unless the latter is too fast to have stopped; below
  /// min_speed_mps it stands. Else that takes all of:
  /// - in the nearest scan before that would show kShownSpeed_mps, most rays at its points that did not end
  ///   before them ended on them;
  /// - standing explains at least kStandingExplains of the rays of the next scan and those up to kRecentGap
  ///   before, kExplainsAlone where the standard deviation of the velocity, `std_mps`, is large;
  /// - and at least kStandsBetter more of them than the velocity does [m/s].
  [[nodiscard]] bool stands(std::span<const std::int32_t> object, const Eigen::Vector3d& velocity_0,
                            double std_mps) const;

 private:
  struct Reference {
    FreespaceProbe probe;
    int gap;
    double before_s;  // since then; below 0: until then
  };
  // Rays that pass the points of an object.
  struct Tally {
    int surface = 0, through = 0, hidden = 0;
    void add(FreespaceVerdict verdict) {
      surface += verdict == FreespaceVerdict::border ? 1 : 0;
      through += verdict == FreespaceVerdict::inside ? 1 : 0;
      hidden += verdict == FreespaceVerdict::outside ? 1 : 0;
    }
    [[nodiscard]] int all() const { return surface + through + hidden; }
  };
  struct Sample;

  // Velocity of the surface, if the rays of the scans beside this one fix it.
  [[nodiscard]] std::optional<SlowMotion> measured_by_rays(const Sample& sample) const;
  [[nodiscard]] bool seen_standing_before(const Sample& sample) const;
  [[nodiscard]] Tally recent_rays(const Sample& sample, const Eigen::Vector3d& velocity_0) const;
  // Calls `take(number, answer)` for each point, moved back by the velocity.
  template <class Take>
  static void observe(const Reference& reference, const Sample& sample, const Eigen::Vector3d& velocity_0,
                      Take&& take);

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  SurfaceNormals normals_;
  double min_speed_mps_;
  std::vector<Reference> recent_;   // 1, 2 and 4 scans before, and the next
  std::vector<Reference> earlier_;  // from kRecentGap on, the nearest first
};

}  // namespace mapless
