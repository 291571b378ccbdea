#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Whether a point may be dynamic at all. Published method: its distance from the reference scan. Voting:
/// dynamic if any scan is evidence for it, matched if scans only observed a surface there.
enum class CandidateVerdict : std::uint8_t { not_compared, matched, dynamic };

/// The box filter of the published method, or the seeds of voting (votes of a point and its neighbours).
enum class FilterVerdict : std::uint8_t { not_evaluated, kept, removed };

/// Clustering and region growth.
enum class GrowthVerdict : std::uint8_t {
  not_reached,
  seed,
  grown,
  too_small,    ///< its cluster has too few seeds
  static_track  ///< its track is classified as static (method "voting")
};

/// The verdict of every stage on one point. Method "voting" fills `past` and `future` with the sign of a sum
/// of votes: inside above 0, border below, unobserved at 0.
struct StageTrace {
  CandidateVerdict candidate = CandidateVerdict::not_compared;  ///< paper step 2
  FreespaceVerdict past = FreespaceVerdict::not_evaluated;      ///< step 3, backward: earlier scans
  FreespaceVerdict future =
      FreespaceVerdict::not_evaluated;  ///< step 3, forward: a later scan; voting: all scans
  FilterVerdict filtered = FilterVerdict::not_evaluated;  ///< step 4
  GrowthVerdict growth = GrowthVerdict::not_reached;      ///< step 5

  bool operator==(const StageTrace&) const = default;
};

/// The stages of the pipeline in order, see StageTrace.
enum class Stage : std::uint8_t { candidate, past, future, filtered, growth };
inline constexpr int kStageCount = 5;
using StageNames = std::array<std::string_view, kStageCount>;
inline constexpr StageNames kVotingStageNames = {"candidates", "past evidence", "past and future",
                                                 "neighbour support", "region growth"};
inline constexpr StageNames kPublishedStageNames = {"pointcloud comparison", "freespace backward",
                                                    "freespace forward", "box filter", "region growth"};
/// What each stage is called in tables.
[[nodiscard]] constexpr const StageNames& stage_names(DetectionMethod method) {
  return method == DetectionMethod::voting ? kVotingStageNames : kPublishedStageNames;
}

/// Whether the point is dynamic after `stage`.
[[nodiscard]] constexpr bool dynamic_after(const StageTrace& t, Stage stage) {
  switch (stage) {
    case Stage::candidate:
      return t.candidate == CandidateVerdict::dynamic;
    case Stage::past:
      return t.past == FreespaceVerdict::inside;
    case Stage::future:  // where it was evaluated it replaces the verdict of the past scans
      return t.future == FreespaceVerdict::inside ||
             (t.future == FreespaceVerdict::not_evaluated && t.past == FreespaceVerdict::inside);
    case Stage::filtered:
      return t.filtered == FilterVerdict::kept;
    case Stage::growth:
      return t.growth == GrowthVerdict::seed || t.growth == GrowthVerdict::grown;
  }
  return false;
}

/// A dynamic object in one scan, in the world frame 0: its place, velocity and track. Its points are the
/// returns with its `number` in Detection::object; a point measured at time t_i is at p_0 + velocity_0 (t -
/// t_i) at time t.
struct TrackedObject {
  std::uint32_t id = 0;      ///< kept over scans, never reused: 1, 2, ... in the order of their first scans
  std::uint16_t number = 0;  ///< in Detection::object, of this scan alone
  Time time;                 ///< mean instant of its points; centre, extent and velocity are at this time
  int points = 0;            ///< number of its points
  /// Box of its points, each moved with velocity_0 to `time`; its sides are along the axes of the world.
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();               ///< [m]
  Eigen::Vector3d extent_0 = Eigen::Vector3d::Zero();               ///< lengths of the sides [m]
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();             ///< of its visible surface [m/s]
  Eigen::Matrix3d velocity_covariance_0 = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
  int age = 1;  ///< scans since the track began, the first and this one counted

  /// Standard deviation of the velocity along each axis of the world [m/s].
  [[nodiscard]] Eigen::Vector3d velocity_std_0() const {
    return velocity_covariance_0.diagonal().cwiseSqrt();
  }
};

/// Wall time of each step for one scan [s].
struct StageSeconds {
  double compensation = 0;
  double neighbours = 0;  ///< building the search structure
  double normals = 0;
  double comparison = 0;  ///< method "published", like the next two
  double backward = 0;
  double forward = 0;
  double evidence = 0;  ///< method "voting": of all reference scans
  double filter = 0;
  double region_growth = 0;
  double tracking = 0;

  [[nodiscard]] double total() const {
    return compensation + neighbours + normals + comparison + backward + forward + evidence + filter +
           region_growth + tracking;
  }
  [[nodiscard]] StageSeconds operator+(const StageSeconds& o) const {
    return {compensation + o.compensation, neighbours + o.neighbours, normals + o.normals,
            comparison + o.comparison,     backward + o.backward,     forward + o.forward,
            evidence + o.evidence,         filter + o.filter,         region_growth + o.region_growth,
            tracking + o.tracking};
  }
};

/// The detection of one scan: which of its points are dynamic, and the objects they form. `trace` and
/// `object` have one element per return of `scan`, in its order.
struct Detection {
  std::shared_ptr<const LidarScan> scan;
  std::size_t sequence_number = 0;    ///< 0 for the first scan the detector was given
  std::vector<StageTrace> trace;      ///< verdict of each stage
  std::vector<std::uint16_t> object;  ///< 0: static; 1, 2, ...: the dynamic object of this scan it belongs to
  /// One per return: the probability that it moves. Calibrated: of the points given .9, nine in ten move
  /// (docs/accuracy.md). Empty for method "published", and where `motion_known` is false.
  std::vector<float> probability;
  int objects = 0;                     ///< number of dynamic objects
  std::vector<TrackedObject> tracked;  ///< their tracks, ordered by number
  StageSeconds seconds;
  /// False where the motion of the sensor was lost: no point is known to be dynamic or static, and `object`
  /// is 0 throughout.
  bool motion_known = true;

  /// Whether return i is dynamic.
  [[nodiscard]] bool dynamic(std::size_t i) const { return object[i] != 0; }
};

}  // namespace mapless
