#include "odometry/start_up/start_up.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>

#include "odometry/solver/motion_density.hpp"
#include "odometry/start_up/backward_registration.hpp"
#include "odometry/start_up/joint_registration.hpp"

namespace mapless::inline v1 {
namespace {

// Two motions are undecided while their scores differ by less than this many standard deviations of the
// number of independent points, sqrt(kInformationRatio n) of weight 1 / kInformationRatio each. Chosen: 95 %.
// Measured after five scans of 175 VLP-16 recordings: of the three worst starts (.2 to .7 m off over four
// scans) another motion is within 1.0 to 1.3 of the best, of the others none within 2.8; with 1.5 sqrt(n), .8
// of these, all three were decided there and then.
constexpr double kDecidedSigmas = 2;
// Soft inliers that one agreeing edge outweighs. Chosen: on motorways the right motion has 50 to 100 agreeing
// edges a scan more than any other, while wrong motions have up to 100 soft inliers more (sixteen lasers:
// ground and barriers have inliers for any motion along them).
constexpr double kEdgeWeight = 10;
// The refined start replaces the best hypothesis if it has at least this part of its score. Chosen: the map
// of a wrong first motion is blurred and has planes in more places, which gives it some inliers more.
constexpr double kMinRefinedScoreRatio = 0.9;
// Without edges, the first two scans constrain their motion if the soft inliers are at least this part of the
// keypoints. Measured: .04 to .09 with sixteen lasers above a hill and on motorways, .11 and more in forests,
// towns and tunnels.
constexpr double kMinPairInlierRatio = 0.1;
// Fewest score per keypoint of a motion from rest. Measured: at least .73 above a hill; at most .24 if the
// sensor in fact moves at 29 m/s.
constexpr double kMinFromRestScoreRatio = 0.5;

// Five scans do not settle the motion while the position of the newest is known to less than this along some
// direction. Measured after five scans (docs/notebook/odometry.md, "Steps along a valley"): VLP-16 in bare
// tunnels .011 to .016 m, above hills .011 to .027; HDL-64E mostly .003 to .006, above bare hills .011.
constexpr double kSettledSigma_m = 0.01;

// The negative log-likelihood of the motion between the scan's two knots under the motion prior.
double motion_cost(const MappedTrajectory& mapped, const UsableScan& scan,
                   const AccelerationDensity& density) {
  const TrajectoryKnot& k1 = mapped.knots[scan.interval];
  const TrajectoryKnot& k2 = mapped.knots[scan.interval + 1];
  const Vector12d e = motion_error(k1, k2);
  return 0.5 * e.dot(motion_information((k2.time - k1.time).seconds(), density) * e);
}

std::vector<Eigen::Vector3d> edges_along(const MappedTrajectory& mapped, const UsableScan& scan) {
  return edges_in_world(scan.edges, scan.start, mapped.knots[scan.interval], mapped.knots[scan.interval + 1]);
}

}  // namespace

StartUp::StartUp(const OdometryParameters& parameters, const RegistrationSettings& settings,
                 const std::vector<TrajectoryKnot>& knots)
    : map_radius_m_(parameters.map_radius_m),
      point_sigma_m_(parameters.residual_sigma_m),
      settings_(settings),
      initial_(point_sigma_m_) {
  hypotheses_.push_back({MappedTrajectory(point_sigma_m_), {}, 0, {}});
  if (knots.empty()) return;
  first_open_knot_ = knots.size() - 2;
  hypotheses_.front().mapped.knots = knots;
  hypotheses_.front().mapped.restart_window_at(first_open_knot_);
}

void StartUp::append_knots(const LidarScan& scan, Time end) {
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.mapped.append_knots(scan, end);
}

Matrix12d StartUp::extrapolate_with_prior() {
  Matrix12d covariance = Matrix12d::Zero();
  for (std::size_t i = hypotheses_.size(); i-- > 0;)
    covariance = hypotheses_[i].mapped.extrapolate_with_prior(settings_);
  return covariance;
}

void StartUp::set_first(UsableScan scan) {
  scans_.clear();
  scans_.push_back(std::move(scan));
}

StartUp::Result StartUp::add(UsableScan scan) {
  scans_.push_back(std::move(scan));
  if (!(scans_.size() == 2 ? register_first_pair() : extend_all())) return restart();
  Result result = {hypotheses_.front().registration, scans_.front().interval};
  if (scans_.size() < kMinScans) return result;
  const bool undecided = is_undecided();
  was_undecided_ = was_undecided_ || undecided;
  if (scans_.size() < kMaxScans && (undecided || !is_settled())) return result;
  if (!pair_is_constrained_ && unregistered_.size() + scans_.size() < kJointScans) return result;
  return decide();
}

StartUp::Result StartUp::decide() {
  Result result = {hypotheses_.front().registration, scans_.front().interval};
  decided_ = true;
  if (!pair_is_constrained_) {
    const std::size_t first = start_up_scans().front().interval;
    if (auto from_rest = try_from_rest(score_of(best()))) return {std::move(from_rest), first};
  }
  refine_first_scans();
  if (const auto joint = refine_jointly()) result.registration = joint;
  return result;
}

StartUp::Result StartUp::restart() {
  hypotheses_.resize(1, hypotheses_.front());
  MappedTrajectory& mapped = hypotheses_.front().mapped;
  mapped.marginalises = false;
  (void)mapped.extrapolate_with_prior(settings_);
  mapped.clear_map();
  mapped.restart_window_at(scans_.back().interval);
  UsableScan newest = std::move(scans_.back());
  scans_.pop_back();
  std::move(scans_.begin(), scans_.end(), std::back_inserter(unregistered_));
  std::erase_if(unregistered_,
                [&](const UsableScan& one) { return one.interval + kJointScans <= newest.interval; });
  set_first(std::move(newest));
  if (unregistered_.size() + 1 < kJointScans) return {};
  const std::size_t first = unregistered_.front().interval;
  auto from_rest = try_from_rest(0);
  unregistered_.clear();  // they did not help: later scans do without them
  decided_ = from_rest.has_value();
  return {std::move(from_rest), first};
}

// All scans so far, with those that fitted no hypothesis.
std::vector<UsableScan> StartUp::start_up_scans() const {
  std::vector<UsableScan> out = unregistered_;
  out.insert(out.end(), scans_.begin(), scans_.end());
  return out;
}

RecentEdges StartUp::recent_edges() const {
  RecentEdges out;
  for (const UsableScan& scan : scans_) out.add(edges_along(best(), scan));
  return out;
}

// Soft inliers of all scans, each against the map of the others.
double StartUp::score_of(const MappedTrajectory& mapped) const {
  return soft_inliers_of(mapped.knots, start_up_scans(), settings_);
}

StartUp::JointProblem StartUp::joint_problem(std::vector<UsableScan> scans) const {
  MappedTrajectory mapped(point_sigma_m_);
  mapped.knots = best().knots;
  mapped.restart_window_at(scans.front().interval);
  for (UsableScan& scan : scans) scan.interval -= mapped.window_begin;
  return {std::move(mapped), std::move(scans)};
}

// Registers all scans jointly from rest. The result replaces the best hypothesis if its score is at least
// `min_score` and half of the keypoints.
std::optional<Registration> StartUp::try_from_rest(double min_score) {
  const std::vector<UsableScan> all = start_up_scans();
  auto [from_rest, scans] = joint_problem(all);
  auto registration = register_from_rest(from_rest.window(), from_rest.prior, scans, settings_);
  if (!registration ||
      !is_plausible(registration->knots.back(), from_rest.prior.mean.front(), from_rest.last_interval_s()))
    return std::nullopt;
  if (is_contradicted(registration->knots, settings_)) return std::nullopt;
  from_rest.marginalises = true;
  from_rest.accept(*registration);
  double keypoints = 0;
  for (const UsableScan& scan : all) keypoints += static_cast<double>(scan.bins.points().size());
  if (score_of(from_rest) < std::max(min_score, kMinFromRestScoreRatio * keypoints)) return std::nullopt;
  for (const UsableScan& scan : all) from_rest.insert(scan, map_radius_m_);
  hypotheses_.front().mapped = std::move(from_rest);
  return registration;
}

StartUp::Hypothesis StartUp::hypothesis_of(Registration registration) const {
  Hypothesis hypothesis = {initial_, std::move(registration), 0, {}};
  hypothesis.mapped.marginalises = true;
  hypothesis.mapped.accept(hypothesis.registration);
  for (const std::size_t s : {0, 1}) {
    hypothesis.mapped.insert(scans_[s], map_radius_m_);
    hypothesis.edges.insert(edges_along(hypothesis.mapped, scans_[s]));
  }
  return hypothesis;
}

PairOfScans StartUp::pair() const {
  return {initial_.window(), initial_.prior, scans_[0], scans_[1], initial_.window_begin, settings_};
}

bool StartUp::register_first_pair() {
  initial_ = hypotheses_.front().mapped;
  auto [registrations, by_edges] = pair().candidates();
  std::vector<Hypothesis> found;
  found.reserve(registrations.size());
  for (Registration& registration : registrations) {
    if (is_plausible(registration.knots.back(), initial_.knots.back(), initial_.last_interval_s()))
      found.push_back(hypothesis_of(std::move(registration)));
  }
  if (found.empty()) return false;
  hypotheses_ = std::move(found);
  pair_is_constrained_ =
      by_edges || hypotheses_.front().registration.soft_inliers >=
                      kMinPairInlierRatio * static_cast<double>(scans_[1].bins.points().size());
  return true;
}

// Registers the scan to the map of the hypothesis. False if that fails.
bool StartUp::extend(const UsableScan& scan, Hypothesis& hypothesis) const {
  MappedTrajectory& mapped = hypothesis.mapped;
  auto found = register_scan(mapped.window(), mapped.prior, scan.bins, mapped.map, settings_);
  if (!found || !is_plausible(found->knots.back(), mapped.knots.back(), mapped.last_interval_s()))
    return false;
  hypothesis.registration = std::move(*found);
  mapped.accept(hypothesis.registration);
  const std::vector<Eigen::Vector3d> edges = edges_along(mapped, scan);
  hypothesis.score += hypothesis.registration.soft_inliers + kEdgeWeight * hypothesis.edges.agreement(edges) -
                      motion_cost(mapped, scan, settings_.density);
  hypothesis.edges.insert(edges);
  mapped.insert(scan, map_radius_m_);
  return true;
}

bool StartUp::extend_all() {
  std::vector<char> extended(hypotheses_.size());
  tbb::parallel_for(std::size_t{0}, hypotheses_.size(),
                    [&](std::size_t i) { extended[i] = extend(scans_.back(), hypotheses_[i]) ? 1 : 0; });
  std::vector<Hypothesis> kept;
  kept.reserve(hypotheses_.size());
  for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
    if (extended[i] != 0) kept.push_back(std::move(hypotheses_[i]));
  }
  if (kept.empty()) return false;
  hypotheses_ = std::move(kept);
  keep_if_any(hypotheses_,
              [&](const Hypothesis& one) { return !is_contradicted(one.mapped.knots, settings_); });
  prune_by_inliers();
  prune_by_score();
  return true;
}

// The first two scans were registered to each other alone and err most. They are registered again with the
// velocity that the later scans have determined, and then the later scans to the new map. Measured without: a
// VLP-16 flyer of the second simulator errs by .041 m over four scans for .007, two motorways by .019 and
// .074 for .015 and .058; seventeen recordings are the same to .003 m.
void StartUp::refine_first_scans() {
  const MappedTrajectory& best = hypotheses_.front().mapped;
  Vector6d varpi = best.knots[scans_[2].interval].varpi;  // the turn rate nearest to them
  varpi.head<3>() = best.knots.back().varpi.head<3>();
  auto registration = pair().register_near(varpi);
  if (!registration) return;
  Hypothesis again = hypothesis_of(std::move(*registration));
  for (std::size_t s = 2; s < scans_.size(); ++s) {
    while (again.mapped.knots.size() < scans_[s].interval + 2) {
      const Time time = best.knots[again.mapped.knots.size()].time;
      again.mapped.knots.push_back(predicted(again.mapped.knots.back(), time));
    }
    if (!extend(scans_[s], again)) return;
  }
  if (again.score > kMinRefinedScoreRatio * hypotheses_.front().score) hypotheses_.front() = std::move(again);
}

void StartUp::prune_by_inliers() {
  double most = 0;
  for (const Hypothesis& one : hypotheses_) most = std::max(most, one.registration.soft_inliers);
  std::erase_if(hypotheses_, [&](const Hypothesis& one) {
    return one.registration.soft_inliers < kMinInliersOfMost * most;
  });
}

// Keeps the better half of the hypotheses, at least two, and of hypotheses that are alike only the best.
void StartUp::prune_by_score() {
  std::stable_sort(hypotheses_.begin(), hypotheses_.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
  std::vector<Hypothesis> kept;
  kept.reserve(hypotheses_.size());
  const std::size_t max_kept = std::max<std::size_t>(2, (hypotheses_.size() + 1) / 2);
  for (Hypothesis& hypothesis : hypotheses_) {
    const bool duplicate = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& one) {
      return are_alike(one.mapped.knots.back(), hypothesis.mapped.knots.back());
    });
    if (!duplicate && kept.size() < max_kept) kept.push_back(std::move(hypothesis));
  }
  hypotheses_ = std::move(kept);
}

// The mean velocity from the start of the first scan to the end of the newest, as varpi.
Vector6d StartUp::mean_velocity(const Hypothesis& hypothesis) const {
  const TrajectoryKnot& first = hypothesis.mapped.knots[scans_.front().interval];
  const TrajectoryKnot& last = hypothesis.mapped.knots.back();
  return (last.T_v0 * first.T_v0.inverse()).log() / (last.time - first.time).seconds();
}

// Whether the score of another motion, which differs from the best, is within the noise of the best score.
// Motions that have led to the same place are the same: the turn rate at the end of a scan, by which
// prune_by_score() compares, is hardly known.
bool StartUp::is_undecided() const {
  double keypoints = 0;
  for (std::size_t s = 2; s < scans_.size(); ++s)
    keypoints += static_cast<double>(scans_[s].bins.points().size());
  const Hypothesis& best = hypotheses_.front();
  const double enough = best.score - kDecidedSigmas * std::sqrt(keypoints / kInformationRatio);
  return std::any_of(hypotheses_.begin() + 1, hypotheses_.end(), [&](const Hypothesis& one) {
    return one.score > enough && !are_alike(mean_velocity(one), mean_velocity(best));
  });
}

// Whether the position of the newest scan is known well along every direction.
bool StartUp::is_settled() const {
  const Matrix12d covariance = hypotheses_.front().registration.last_information.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of_position(covariance.topLeftCorner<3, 3>(),
                                                                   Eigen::EigenvaluesOnly);
  return of_position.eigenvalues().maxCoeff() <= kSettledSigma_m * kSettledSigma_m;
}

// The settings with the density of the rotation of these scans: a walking person rolls the sensor at 4
// rad/s^2, 12 times what the expected density allows in a scan. That of the translation stays the expected
// one: along a direction that planes hardly fix, changes of the estimated velocity are its errors. Measured:
// with both observed, VLP-16 flights err several times as much (docs/notebook/odometry.md, "The joint
// registration of the first scans").
RegistrationSettings StartUp::with_observed_rotation(std::span<const TrajectoryKnot> knots) const {
  RegistrationSettings out = settings_;
  out.density.rotation = estimate_density(knots, settings_.density).rotation;
  return out;
}

std::optional<Registration> StartUp::refine_jointly() {
  MappedTrajectory& mapped = hypotheses_.front().mapped;
  auto [joint, scans] = joint_problem(scans_);
  std::vector<TrajectoryKnot> knots = joint.window();
  if (auto back = follow_backwards(knots, scans, with_observed_rotation(knots))) knots = std::move(*back);
  auto registration = register_jointly(knots, joint.prior, scans, with_observed_rotation(knots));
  if (!registration ||
      !is_plausible(registration->knots.back(), mapped.knots.back(), mapped.last_interval_s()))
    return std::nullopt;
  joint.marginalises = true;
  joint.accept(*registration);
  for (const UsableScan& scan : scans_) joint.insert(scan, map_radius_m_);
  mapped = std::move(joint);
  return registration;
}

}  // namespace mapless
