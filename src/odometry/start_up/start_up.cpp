#include "odometry/start_up/start_up.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <tbb/parallel_for.h>

#include "odometry/start_up/joint_registration.hpp"

namespace mapless::inline v1 {
namespace {

// Another motion whose score comes so near to the best leaves the start uncertain, and so does a best one
// that few points agree with. The four wrong ones of 18 starts on simulated motorways, from
// which both numbers are chosen, showed one or the other; so did six of the right ones.
constexpr double kAmbiguous = 0.75;
// A motion is clearly better by so many standard deviations of the number of points asked.
constexpr double kClearlyMore = 1.5;
constexpr double kWell = 0.8;  // times the keypoints of a scan, of three at most
// A point in the freespace of other scans counts against a motion as so many that agree speak for it: walls
// and ground agree with any motion along them, but with the right motion no wall lies in freespace, only what
// moves itself.
constexpr double kThroughCounts = 10;
// A map that a wrong motion has smeared has planes in more places, and a few more points agree with it.
constexpr double kFarSpeed = 3;  // [m/s]
constexpr double kAboutAsGood = 0.9;
// A motion with which so much fewer points agree than with another leaves most of the scan where nothing was.
constexpr double kFarFewer = 0.5;
// Two scans of which a smaller share agrees with any motion do not hold one another: .04 to .09 of sixteen
// lasers on top of a hill and on a motorway, .11 and more in forests, towns and tunnels.
constexpr double kFewAgree = 0.1;
// Of all points, what is to agree with a motion from rest, less those in freespace: .73 and more on top of
// a hill, at rest on a motorway at most .24.
constexpr double kAgreeFromRest = 0.5;

// What the motion between the scan's two knots costs by the prior: half the squared error, as a logarithm of
// probability.
double motion_cost(const MappedTrajectory& track, const UsableScan& scan,
                   const AccelerationDensity& density) {
  const TrajectoryKnot& k1 = track.knots[scan.interval];
  const TrajectoryKnot& k2 = track.knots[scan.interval + 1];
  const Vector12d e = motion_error(k1, k2);
  return 0.5 * e.dot(motion_information((k2.time - k1.time).seconds(), density) * e);
}

// Points of the scan in the freespace of each scan before it, in the mean.
double freespace_violations(const MappedTrajectory& track, const std::vector<UsableScan>& others,
                            const UsableScan& scan) {
  const KnotInterval interval(track.knots[scan.interval], track.knots[scan.interval + 1]);
  double inside = 0;
  int scans = 0;
  for (const UsableScan& other : others) {
    if (other.interval == scan.interval) break;
    const KnotInterval own(track.knots[other.interval], track.knots[other.interval + 1]);
    inside += other.freespace->count_inside(own, scan.bins, interval);
    ++scans;
  }
  return inside / scans;
}

// Farther than one of them can be found from the other in the scans to come.
bool are_far(const MappedTrajectory& a, const MappedTrajectory& b) {
  return (a.knots.back().varpi - b.knots.back().varpi).head<3>().norm() > kFarSpeed;
}

}  // namespace

StartUp::StartUp(const OdometryParameters& parameters, const RegistrationSettings& settings)
    : map_radius_m_(parameters.map_radius_m),
      sigma_m_(parameters.residual_sigma_m),
      settings_(settings),
      unmoved_(sigma_m_) {
  candidates_.push_back({MappedTrajectory(sigma_m_), {}, 0});
}

void StartUp::append_knots(const LidarScan& scan, Time end) {
  for (Candidate& candidate : candidates_) candidate.track.append_knots(scan, end);
}

Matrix12d StartUp::carry_by_prior() {
  Matrix12d covariance = Matrix12d::Zero();
  for (std::size_t i = candidates_.size(); i-- > 0;)
    covariance = candidates_[i].track.carry_by_prior(settings_);
  return covariance;
}

void StartUp::begin_with(UsableScan scan) {
  scans_.clear();
  scans_.push_back(std::move(scan));
}

StartUp::Result StartUp::add(UsableScan scan) {
  scans_.push_back(std::move(scan));
  if (!(scans_.size() == 2 ? follow_pair() : follow_all())) return begin_anew();
  Result result = {candidates_.front().registration, false};
  if (scans_.size() < kFewestScans) return result;
  ambiguous_ = ambiguous_ || is_ambiguous();
  if (scans_.size() < kMostScans && may_be_another()) return result;
  if (!told_by_pair_ && unplaced_.size() + scans_.size() < kTogether) return result;
  return decide();
}

StartUp::Result StartUp::decide() {
  Result result = {candidates_.front().registration, ambiguous_};
  decided_ = true;
  if (!told_by_pair_) {
    if (auto from_rest = registered_from_rest(worth(best()))) return {std::move(from_rest), ambiguous_};
  }
  follow_again();
  if (const auto joint = registered_jointly()) result.registration = joint;
  return result;
}

StartUp::Result StartUp::begin_anew() {
  candidates_.resize(1, candidates_.front());
  MappedTrajectory& track = candidates_.front().track;
  track.marginalises = false;
  (void)track.carry_by_prior(settings_);
  track.clear_map();
  track.begin_anew_at(scans_.back().interval);
  UsableScan newest = std::move(scans_.back());
  scans_.pop_back();
  std::move(scans_.begin(), scans_.end(), std::back_inserter(unplaced_));
  std::erase_if(unplaced_,
                [&](const UsableScan& one) { return one.interval + kTogether <= newest.interval; });
  begin_with(std::move(newest));
  if (unplaced_.size() + 1 < kTogether) return {};
  auto from_rest = registered_from_rest(0);
  unplaced_.clear();  // in vain: those to come are asked without them
  decided_ = from_rest.has_value();
  return {std::move(from_rest), false};
}

// Those that went with no other, too.
std::vector<UsableScan> StartUp::all_scans() const {
  std::vector<UsableScan> out = unplaced_;
  out.insert(out.end(), scans_.begin(), scans_.end());
  return out;
}

// The points that agree with a motion, each scan's with all the others, less those in the freespace of
// others.
double StartUp::worth(const MappedTrajectory& track) const {
  const std::vector<UsableScan> all = all_scans();
  double out = agreement_of(track.knots, all, settings_);
  for (std::size_t s = 1; s < all.size(); ++s)
    out -= kThroughCounts * freespace_violations(track, all, all[s]);
  return out;
}

// The best motion from the first of the scans on, without a map; they count their intervals from there.
StartUp::Together StartUp::together(std::vector<UsableScan> scans) const {
  MappedTrajectory track(sigma_m_);
  track.knots = best().knots;
  track.begin_anew_at(scans.front().interval);
  for (UsableScan& scan : scans) scan.interval -= track.window_begin;
  return {std::move(track), std::move(scans)};
}

// Takes the place of the best motion where it is worth more than that, and most points agree with it.
std::optional<Registration> StartUp::registered_from_rest(double other_worth) {
  const std::vector<UsableScan> all = all_scans();
  auto [from_rest, scans] = together(all);
  auto registration = register_from_rest(from_rest.window(), from_rest.prior, scans, settings_);
  if (!registration || !is_plausible(registration->knots.back(), from_rest.prior.mean.front()))
    return std::nullopt;
  from_rest.marginalises = true;
  from_rest.accept(*registration);
  double keypoints = 0;
  for (const UsableScan& scan : all) keypoints += static_cast<double>(scan.bins.points().size());
  if (worth(from_rest) < std::max(other_worth, kAgreeFromRest * keypoints)) return std::nullopt;
  for (const UsableScan& scan : all) from_rest.insert(scan, map_radius_m_);
  candidates_.front().track = std::move(from_rest);
  return registration;
}

StartUp::Candidate StartUp::candidate_of(Registration registration) const {
  Candidate candidate = {unmoved_, std::move(registration), 0};
  candidate.track.marginalises = true;
  candidate.track.accept(candidate.registration);
  candidate.track.insert(scans_[0], map_radius_m_);
  candidate.track.insert(scans_[1], map_radius_m_);
  return candidate;
}

PairOfScans StartUp::pair() const {
  return {unmoved_.window(), unmoved_.prior, scans_[0], scans_[1], unmoved_.window_begin, settings_};
}

bool StartUp::follow_pair() {
  unmoved_ = candidates_.front().track;
  std::vector<Registration> registrations = pair().register_all();
  std::vector<Candidate> found;
  found.reserve(registrations.size());
  for (Registration& registration : registrations) {
    if (is_plausible(registration.knots.back(), unmoved_.knots.back()))
      found.push_back(candidate_of(std::move(registration)));
  }
  if (found.empty()) return false;
  candidates_ = std::move(found);
  told_by_pair_ = candidates_.front().registration.agreement >=
                  kFewAgree * static_cast<double>(scans_[1].bins.points().size());
  return true;
}

// False where the scan has no place in the candidate's map.
bool StartUp::follow(const UsableScan& scan, Candidate& candidate) const {
  MappedTrajectory& track = candidate.track;
  auto found = register_scan(track.window(), track.prior, scan.bins, track.map, settings_);
  if (!found || !is_plausible(found->knots.back(), track.knots.back())) return false;
  candidate.registration = std::move(*found);
  track.accept(candidate.registration);
  candidate.score += candidate.registration.agreement -
                     kThroughCounts * freespace_violations(track, scans_, scan) -
                     motion_cost(track, scan, settings_.density);
  track.insert(scan, map_radius_m_);
  return true;
}

bool StartUp::follow_all() {
  std::vector<char> has_place(candidates_.size());
  tbb::parallel_for(std::size_t{0}, candidates_.size(),
                    [&](std::size_t i) { has_place[i] = follow(scans_.back(), candidates_[i]) ? 1 : 0; });
  std::vector<Candidate> followed;
  followed.reserve(candidates_.size());
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (has_place[i] != 0) followed.push_back(std::move(candidates_[i]));
  }
  if (followed.empty()) return false;
  candidates_ = std::move(followed);
  leave_out_far_fewer();
  keep_best();
  return true;
}

// The first two scans were registered to each other alone, and are known worst. Now that more is known of the
// velocity, they are registered again with it, and those after them.
void StartUp::follow_again() {
  const MappedTrajectory& best = candidates_.front().track;
  Vector6d varpi = best.knots[scans_[2].interval].varpi;  // the turn rate nearest to them
  varpi.head<3>() = best.knots.back().varpi.head<3>();
  auto registration = pair().register_near(varpi);
  if (!registration) return;
  Candidate again = candidate_of(std::move(*registration));
  for (std::size_t s = 2; s < scans_.size(); ++s) {
    while (again.track.knots.size() < scans_[s].interval + 2) {
      const Time time = best.knots[again.track.knots.size()].time;
      again.track.knots.push_back(predicted(again.track.knots.back(), time));
    }
    if (!follow(scans_[s], again)) return;
  }
  if (again.score > kAboutAsGood * candidates_.front().score) candidates_.front() = std::move(again);
}

void StartUp::leave_out_far_fewer() {
  double most = 0;
  for (const Candidate& one : candidates_) most = std::max(most, one.registration.agreement);
  std::erase_if(candidates_,
                [&](const Candidate& one) { return one.registration.agreement < kFarFewer * most; });
}

// Half of them, and two at least, of which no two have come to the same motion.
void StartUp::keep_best() {
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  std::vector<Candidate> kept;
  kept.reserve(candidates_.size());
  const std::size_t most = std::max<std::size_t>(2, (candidates_.size() + 1) / 2);
  for (Candidate& candidate : candidates_) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& one) {
      return are_alike(one.track.knots.back(), candidate.track.knots.back());
    });
    if (!known && kept.size() < most) kept.push_back(std::move(candidate));
  }
  candidates_ = std::move(kept);
}

// What the whole motion costs by the prior, its first two scans too.
double StartUp::less_its_cost(const Candidate& candidate) const {
  double out = candidate.score;
  for (const UsableScan& scan : scans_) out -= motion_cost(candidate.track, scan, settings_.density);
  return out;
}

// Whether no clearly larger number of points agrees with the best motion than with another one.
bool StartUp::may_be_another() const {
  double keypoints = 0;
  for (std::size_t s = 2; s < scans_.size(); ++s)
    keypoints += static_cast<double>(scans_[s].bins.points().size());
  const double enough = candidates_.front().score - kClearlyMore * std::sqrt(keypoints);
  return candidates_.size() > 1 && candidates_[1].score > enough;  // no two of them are alike
}

// Motions that lie between the best and another one look good by their points alone, but not by what it costs
// to go from the one to the other within these scans.
bool StartUp::is_ambiguous() const {
  const Candidate& best = candidates_.front();
  if (best.score < kWell * static_cast<double>(scans_.back().bins.points().size())) return true;
  std::vector<double> less_cost;
  for (const Candidate& one : candidates_) less_cost.push_back(less_its_cost(one));
  const double most = *std::max_element(less_cost.begin(), less_cost.end());
  for (std::size_t i = 1; i < candidates_.size(); ++i) {
    const Candidate& other = candidates_[i];
    if (other.score > kAmbiguous * best.score && are_far(other.track, best.track) &&
        (most <= 0 || less_cost[i] > kAmbiguous * most))
      return true;
  }
  return false;
}

std::optional<Registration> StartUp::registered_jointly() {
  MappedTrajectory& track = candidates_.front().track;
  auto [joint, scans] = together(scans_);
  auto registration = register_jointly(joint.window(), joint.prior, scans, settings_);
  if (!registration || !is_plausible(registration->knots.back(), track.knots.back())) return std::nullopt;
  joint.marginalises = true;
  joint.accept(*registration);
  for (const UsableScan& scan : scans_) joint.insert(scan, map_radius_m_);
  track = std::move(joint);
  return registration;
}

}  // namespace mapless
