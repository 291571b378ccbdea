#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "odometry/start_up/edge_votes.hpp"

namespace mapless::inline v1 {

/// A motion with fewer soft inliers than this part of the most is dropped: it moves most of the scan to where
/// the map is empty.
inline constexpr double kMinInliersOfMost = 0.5;

/// What other sensors measure during the first two scans: means, none where nothing is measured.
struct KnownMotion {
  std::optional<Eigen::Vector3d> velocity, angular_velocity;  ///< in the sense of varpi
  std::optional<double> speed;

  /// `varpi` with what is measured in its place; a speed only changes the length of a velocity.
  [[nodiscard]] Vector6d applied_to(Vector6d varpi) const;
};

/// Registers the second scan of a recording to the first, without any knowledge of the velocity. Edges are
/// tried first: with few lasers planes fit many motions along a road, and a registration to planes alone
/// leaves the right one. After every step the first scan is compensated again with the motion found.
class PairOfScans {
 public:
  /// `knots` begin with knot number `first_knot`, in which UsableScan::interval counts. The second scan is in
  /// the last interval.
  PairOfScans(std::vector<TrajectoryKnot> knots, WindowPrior prior, const UsableScan& first,
              const UsableScan& second, std::size_t first_knot, const RegistrationSettings& settings);

  /// Motions for later scans to decide between: no two alike (are_alike), none with fewer than 50 soft
  /// inliers, and where any agrees with the measurements of other sensors, only such.
  struct Candidates {
    std::vector<Registration> all;
    bool by_edges = false;  ///< the edges of the two scans coincide under one of them at least
  };
  /// The motions under which the edges of the two scans coincide (edge_motions), each registered to planes
  /// with the information of its edges as a prior. Where the edges admit none, or agree badly
  /// (kSureAgreement), also all motions that planes admit.
  [[nodiscard]] Candidates candidates() const;
  /// The motion near a velocity that is known to 0.5 m/s and 0.5 rad/s.
  [[nodiscard]] std::optional<Registration> register_near(const Vector6d& varpi) const;

 private:
  [[nodiscard]] WindowPrior velocity_prior(const Vector6d& varpi, double speed_sigma,
                                           double turn_rate_sigma) const;
  bool iterate(double scale, int steps, bool coarse, const WindowPrior& prior,
               Registration& registration) const;
  bool refine(Registration& registration) const;
  void fill(const Registration& registration, double scale, bool coarse, PlaneMap& map) const;
  [[nodiscard]] std::optional<Registration> register_coarsely(const Vector6d& varpi) const;
  [[nodiscard]] std::optional<Registration> register_at_speed(const Vector6d& varpi,
                                                              const Eigen::Vector3d& direction) const;
  struct EdgeCandidate {
    WindowPrior prior;  // the velocity of the edges
    Registration registration;
    bool solved = false;
  };
  [[nodiscard]] WindowPrior prior_of_edges(const EdgeMotion& motion) const;
  [[nodiscard]] std::vector<EdgeCandidate> edge_candidates(const std::vector<EdgeMotion>& motions) const;
  [[nodiscard]] std::vector<Registration> register_by_edges(const std::vector<EdgeMotion>& motions) const;
  [[nodiscard]] std::vector<Registration> register_by_planes() const;
  [[nodiscard]] std::vector<Registration> coarse_registrations() const;
  [[nodiscard]] KnownMotion known_motion() const;
  void add_along_weak_directions(std::vector<Registration>& all) const;

  std::vector<TrajectoryKnot> knots_;
  WindowPrior prior_;
  const UsableScan& first_;
  const UsableScan& second_;
  std::size_t first_interval_;
  const RegistrationSettings& settings_;
  std::vector<ScanPoint> coarse_points_;  // of the first scan
};

/// Keeps the elements for which `agrees` is true, all of them if it is true for none.
template <class T, class Predicate>
void keep_if_any(std::vector<T>& all, const Predicate& agrees) {
  if (std::any_of(all.begin(), all.end(), agrees))
    std::erase_if(all, [&](const T& one) { return !agrees(one); });
}

/// The same for the velocities at the end of two motions.
[[nodiscard]] bool are_alike(const TrajectoryKnot& a, const TrajectoryKnot& b);

}  // namespace mapless
