#pragma once

#include <optional>
#include <vector>

#include "odometry/start_up/pair_registration.hpp"
#include <mapless/odometry/parameters.hpp>

namespace mapless::inline v1 {

/// Finds how a sensor moves that may be moving from its very first scan on. Two scans of few lasers often do
/// not tell (on a motorway the ground agrees with any speed): every motion that may have been is followed for
/// a few scans more, and the one that most points agree with is kept and its first scans registered anew, all
/// of them together. Where hardly a point of the one finds a place in the other (sixteen lasers on top of a
/// hill), as many scans as tell something together are registered from rest too.
class StartUp {
 public:
  /// Scans the motion is decided from, where they tell it.
  static constexpr std::size_t kFewestScans = 5;
  /// Where they leave two motions about as likely: until one is left, and at most so many.
  static constexpr std::size_t kMostScans = 10;
  /// Where two scans do not hold one another: those that are registered from rest.
  static constexpr std::size_t kTogether = 8;

  StartUp(const OdometryParameters& parameters, const RegistrationSettings& settings);

  /// As MappedTrajectory has it.
  void append_knots(const LidarScan& scan, Time end);
  /// For a scan that cannot be used; returns the covariance.
  Matrix12d carry_by_prior();

  /// The first usable scan, or one to begin anew with.
  void begin_with(UsableScan scan);
  [[nodiscard]] bool has_first() const { return !scans_.empty(); }

  struct Result {
    std::optional<Registration> registration;  ///< of the best motion so far; none: begun anew with this scan
    bool ambiguous = false;                    ///< another motion explains the scans about as well
  };
  /// A scan after the first.
  Result add(UsableScan scan);

  [[nodiscard]] bool decided() const { return decided_; }
  /// With the best motion so far; once decided, with the only one.
  [[nodiscard]] const MappedTrajectory& best() const { return candidates_.front().track; }

 private:
  struct Candidate {
    MappedTrajectory track;
    Registration registration;  // of the newest scan
    // Of the scans from the third on: agreeing points, less those that other scans saw through, less what the
    // motion costs by the prior.
    double score = 0;
  };

  [[nodiscard]] PairOfScans pair() const;
  [[nodiscard]] Candidate candidate_of(Registration registration) const;
  bool follow_pair();
  bool follow_all();
  bool follow(const UsableScan& scan, Candidate& candidate) const;
  void follow_again();
  void leave_out_far_fewer();
  void keep_best();
  [[nodiscard]] double less_its_cost(const Candidate& candidate) const;
  [[nodiscard]] bool may_be_another() const;
  [[nodiscard]] bool is_ambiguous() const;
  std::optional<Registration> registered_jointly();
  [[nodiscard]] std::vector<UsableScan> all_scans() const;
  struct Together {
    MappedTrajectory track;
    std::vector<UsableScan> scans;
  };
  [[nodiscard]] Together together(std::vector<UsableScan> scans) const;
  [[nodiscard]] double worth(const MappedTrajectory& track) const;
  std::optional<Registration> registered_from_rest(double other_worth);
  Result decide();
  Result begin_anew();

  double map_radius_m_, sigma_m_;
  RegistrationSettings settings_;
  MappedTrajectory unmoved_;           // before anything was known
  std::vector<Candidate> candidates_;  // best first, one at least
  std::vector<UsableScan> unplaced_;   // the last ones before `scans_`, which went with no other
  std::vector<UsableScan> scans_;
  bool told_by_pair_ = false;  // the first two of them hold one another
  bool ambiguous_ = false;
  bool decided_ = false;
};

}  // namespace mapless
