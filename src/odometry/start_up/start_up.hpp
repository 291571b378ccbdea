#pragma once

#include <optional>
#include <span>
#include <vector>

#include "odometry/map/edge_grid.hpp"
#include "odometry/registration/recent_edges.hpp"
#include "odometry/start_up/pair_registration.hpp"
#include <mapless/odometry/parameters.hpp>

namespace mapless::inline v1 {

/// start_up/ estimates the motion of the first scans of a recording, which may begin at any speed. Usable
/// scans go in one by one; the best motion so far and, once decided, a MappedTrajectory to continue from come
/// out. No other part of the odometry changes its hypotheses.
///
/// Two scans of few lasers often admit many motions (on a motorway the ground fits any speed). All of them
/// are hypotheses, which three to eight more scans extend. The one with the best score is kept, and its scans
/// are registered again: from the last back to the first, then jointly. If even the best motion of the first
/// two scans has few inliers (sixteen lasers above a hill), eight scans are also registered jointly from rest
/// (docs/notebook/odometry.md, "How it starts").
class StartUp {
 public:
  /// Fewest scans before a decision. Chosen: three scans extend the hypotheses of the first two; half a
  /// second at 10 Hz.
  static constexpr std::size_t kMinScans = 5;
  /// Most scans before a decision while two motions are about equally good, or planes hardly fix the best
  /// one. Measured: 3 of 50 motorway starts err by metres, 5 with five scans (same page).
  static constexpr std::size_t kMaxScans = 10;
  /// Scans that are registered jointly from rest if the first two do not constrain the motion. Measured: 1 of
  /// 33 flying starts errs by more than 0.10 m, 24 with five scans (same page).
  static constexpr std::size_t kJointScans = 8;

  /// `knots`: those of the drive so far; empty at its beginning. The last but one keeps its pose, its
  /// velocity is unknown; those before it do not change.
  StartUp(const OdometryParameters& parameters, const RegistrationSettings& settings,
          const std::vector<TrajectoryKnot>& knots = {});

  /// As MappedTrajectory::append_knots, for every hypothesis.
  void append_knots(const LidarScan& scan, Time end);
  /// For a scan that cannot be used. Returns the covariance of the last knot.
  Matrix12d extrapolate_with_prior();

  /// Sets the first usable scan.
  void set_first(UsableScan scan);
  [[nodiscard]] bool has_first() const { return !scans_.empty(); }

  struct Result {
    /// Of the best hypothesis. None if the scan fits no hypothesis; the start-up then restarts with this
    /// scan.
    std::optional<Registration> registration;
    std::size_t first_interval = 0;  ///< UsableScan::interval of the first scan whose motion is decided
  };
  /// Adds a usable scan after the first.
  Result add(UsableScan scan);

  [[nodiscard]] bool decided() const { return decided_; }
  /// Whether another motion was about as good after five scans or later. The first scans may then still have
  /// it, though the last ones do not: each scan follows the map that the ones before it have made.
  [[nodiscard]] bool was_undecided() const { return was_undecided_; }
  /// Number of the first knot that can still change.
  [[nodiscard]] std::size_t first_open_knot() const { return first_open_knot_; }
  /// The trajectory and map of the best hypothesis; once decided, of the only one.
  [[nodiscard]] const MappedTrajectory& best() const { return hypotheses_.front().mapped; }
  /// The edges of the last scans along the best motion.
  [[nodiscard]] RecentEdges recent_edges() const;

 private:
  struct Hypothesis {
    MappedTrajectory mapped;
    Registration registration;  // of the newest scan
    // Over the scans from the third on: soft inliers and agreeing edges, less the cost of the motion prior.
    double score = 0;
    EdgeGrid edges;  // of all scans so far
  };
  // The first scans as one problem without a map; their intervals count from the first of its knots.
  struct JointProblem {
    MappedTrajectory mapped;
    std::vector<UsableScan> scans;
  };

  [[nodiscard]] PairOfScans pair() const;
  [[nodiscard]] Hypothesis hypothesis_of(Registration registration) const;
  bool register_first_pair();
  bool extend_all();
  bool extend(const UsableScan& scan, Hypothesis& hypothesis) const;
  void prune_by_inliers();
  void prune_by_score();
  [[nodiscard]] Vector6d mean_velocity(const Hypothesis& hypothesis) const;
  [[nodiscard]] bool is_undecided() const;
  [[nodiscard]] bool is_settled() const;
  Result decide();
  void refine_first_scans();
  [[nodiscard]] RegistrationSettings with_observed_rotation(std::span<const TrajectoryKnot> knots) const;
  std::optional<Registration> refine_jointly();
  std::optional<Registration> try_from_rest(double min_score);
  Result restart();
  [[nodiscard]] std::vector<UsableScan> start_up_scans() const;
  [[nodiscard]] JointProblem joint_problem(std::vector<UsableScan> scans) const;
  [[nodiscard]] double score_of(const MappedTrajectory& mapped) const;

  double map_radius_m_, point_sigma_m_;
  std::size_t first_open_knot_ = 0;
  RegistrationSettings settings_;
  MappedTrajectory initial_;              // before the first pair was registered
  std::vector<Hypothesis> hypotheses_;    // best first; at least one
  std::vector<UsableScan> unregistered_;  // the last ones before `scans_`, which fitted no hypothesis
  std::vector<UsableScan> scans_;
  bool pair_is_constrained_ = false;  // the best motion of the first two scans has enough inliers
  bool decided_ = false;
  bool was_undecided_ = false;
};

}  // namespace mapless
