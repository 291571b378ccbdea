#include "detection/tracking/object_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>

#include "detection/tracking/longest_absence.hpp"
#include "detection/tracking/object_association.hpp"
#include "detection/tracking/object_registration.hpp"
#include "detection/tracking/object_snapshot.hpp"
#include "detection/tracking/velocity_filter.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Standard deviation of the velocity of a new track, per axis: urban traffic is within one sigma, a highway's
// within three.
constexpr double kNewTrackStd_mps = 15;
// Noise on acceleration, per axis [m^2/s^3]: the velocity changes by sqrt(0.5) = 0.7 m/s in a second of
// steady driving. When objects brake or turn, VelocityFilter raises it by their innovations.
constexpr double kAccelerationDensity = 0.5;
constexpr std::size_t kMaxSnapshots = VelocityFilter::kMaxRemembered;  // earlier scans of a track
// Time between scans that are registered to each other: longer, objects turn and accelerate; shorter, the
// parts of an object cut by the seam of one scan meet.
constexpr double kMaxInterval_s = 0.45, kMinInterval_s = 0.01;

// Further starts are tried for a track of at most kYoungSnapshots snapshots, and where the predicted velocity
// leaves this misfit. Chosen: more than twice kExplained (object_registration.cpp), which an unaffected one
// leaves.
constexpr std::size_t kYoungSnapshots = 2;
constexpr double kMaxMisfit = 0.3;
// Starts this near to each other [m between the scans] lead to the same end: the scale at which descent
// converges.
constexpr double kSameStart_m = 0.1;
// Quantiles of the points at which an object ends along its longest direction: a few outliers do not count.
constexpr std::array kEnds = {0.02, 0.98};
// If another start leaves a misfit smaller by kBetter, the predicted velocity was wrong by this standard
// deviation.
constexpr double kBetter = 0.1;
constexpr double kWrongStd_mps = 10;
// Velocity of a part that splits off, relative to the whole: a person who gets off a bus.
constexpr double kSplitStd_mps = 1;

struct Track {
  std::uint32_t id;
  std::size_t first_scan;
  VelocityFilter filter;
  // Newest first, as the filter remembers them. A part that splits off shares those of the whole.
  std::vector<std::shared_ptr<ObjectSnapshot>> snapshots;
  Time last_scan;         // start of the scan of the newest snapshot
  double diagonal_m = 0;  // of the largest box so far

  [[nodiscard]] const ObjectSnapshot& newest() const { return *snapshots.front(); }
  [[nodiscard]] double newest_diagonal_m() const { return newest().seen_box.diagonal().norm(); }

  void keep(ObjectSnapshot snapshot) {
    filter.remember(kMaxSnapshots);
    snapshots.reserve(kMaxSnapshots);
    if (snapshots.size() == kMaxSnapshots) snapshots.pop_back();
    snapshots.insert(snapshots.begin(), std::make_shared<ObjectSnapshot>(std::move(snapshot)));
    diagonal_m = std::max(diagonal_m, newest_diagonal_m());
  }
  // Releases the scan before the last: only the newest free space is used.
  void release_earlier_scan() {
    if (snapshots.size() > 1) snapshots[1]->rays.reset();
  }
};

void require_usable(const Detection& detection, const std::optional<Time>& newest_start) {
  const std::string scan = "scan " + std::to_string(detection.sequence_number);
  if (detection.scan->compensated_to) {
    throw InputError({scan, "scan", "already compensated for motion", "its points have lost their instants",
                      "take it back to the measured rays first (restore_measured_rays)"});
  }
  if (newest_start && detection.scan->start <= *newest_start) {
    throw InputError({scan, "start", std::to_string(detection.scan->start.nanoseconds()) + " ns",
                      "not after the scan before it", "give detections by increasing time"});
  }
}

// The direction in which the points are spread most, a unit vector.
Vector3d longest_direction(const ObjectSnapshot& snapshot) {
  Matrix3d squares = Matrix3d::Zero();
  for (const SurfaceSample& s : snapshot.surface)
    squares += (s.p_0 - snapshot.mean_0) * (s.p_0 - snapshot.mean_0).transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(squares);
  return solver.eigenvectors().col(2);
}

// The positions of both ends along `direction` [m], robust to a few outliers (kEnds).
std::array<double, 2> ends_along(const ObjectSnapshot& snapshot, const Vector3d& direction) {
  std::vector<double> places(snapshot.points_0.size());
  std::transform(snapshot.points_0.begin(), snapshot.points_0.end(), places.begin(),
                 [&](const Vector3d& p) { return direction.dot(p); });
  std::array<double, 2> out{};
  for (std::size_t end = 0; end < out.size(); ++end) {
    const double rank = kEnds[end] * static_cast<double>(places.size() - 1);
    const auto at = places.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(places.begin(), at, places.end());
    out[end] = *at;
  }
  return out;
}

// Velocities to start a registration from where the predicted one is not good: the shifts of the mean, of the
// centre of the box, and of both ends. The visible part of an object may grow at one end and stay at the
// other.
std::array<Vector3d, 4> starts(const ObjectSnapshot& now, const ObjectSnapshot& before) {
  const double dt = (now.time - before.time).seconds();
  const Vector3d shift = now.mean_0 - before.mean_0;
  const Vector3d along = longest_direction(now);
  const auto ends_now = ends_along(now, along), ends_before = ends_along(before, along);
  const auto shift_of_end = [&](std::size_t end) -> Vector3d {
    return shift + (ends_now[end] - ends_before[end] - along.dot(shift)) * along;
  };
  return {shift / dt, (now.seen_box.center() - before.seen_box.center()) / dt, shift_of_end(0) / dt,
          shift_of_end(1) / dt};
}

// Motion since the newest snapshot, from the predicted velocity; from further starts, too, if the track is
// young or the predicted velocity does not explain the scan.
RegisteredMotion newest_motion(Track& track, const ObjectSnapshot& now) {
  const ObjectSnapshot& before = track.newest();
  RegisteredMotion best = register_snapshots(now, before, track.filter.velocity());
  const bool young = track.snapshots.size() <= kYoungSnapshots;
  if (!young && best.misfit < kMaxMisfit) return best;
  const double predicted_misfit = best.misfit;
  const double near_mps = kSameStart_m / (now.time - before.time).seconds();
  std::array<Vector3d, 9> known = {best.velocity_0};  // starts, and the velocities found from them
  std::size_t count = 1;
  for (const Vector3d& start : starts(now, before)) {
    const auto is_near = [&](const Vector3d& v) { return (start - v).squaredNorm() < near_mps * near_mps; };
    if (std::any_of(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(count), is_near)) continue;
    const RegisteredMotion found = register_snapshots(now, before, start);
    known[count++] = start;
    known[count++] = found.velocity_0;
    if (found.misfit < best.misfit) best = found;
  }
  if (best.misfit < predicted_misfit - kBetter) track.filter.loosen(kWrongStd_mps);
  return best;
}

// The oldest snapshot within kMaxInterval_s: the longer the interval, the better the velocity. 0: the newest
// alone.
std::size_t oldest_to_register(const Track& track, Time now) {
  std::size_t oldest = 0;
  for (std::size_t i = 1; i < track.snapshots.size(); ++i) {
    if ((now - track.snapshots[i]->time).seconds() <= kMaxInterval_s) oldest = i;
  }
  return oldest;
}

void observe(Track& track, const ObjectSnapshot& now) {
  const auto seconds_since = [&](std::size_t past) {
    return (now.time - track.snapshots[past]->time).seconds();
  };
  if (seconds_since(0) < kMinInterval_s) return;
  const RegisteredMotion newest = newest_motion(track, now);
  track.filter.predict(now.time);
  const auto observe_motion = [&](std::size_t past, const RegisteredMotion& motion) {
    const double dt = seconds_since(past);
    track.filter.observe(past, motion.velocity_0 * dt, motion.covariance * dt * dt);
  };
  observe_motion(0, newest);
  if (const std::size_t oldest = oldest_to_register(track, now.time); oldest > 0)
    observe_motion(oldest, register_snapshots(now, *track.snapshots[oldest], track.filter.velocity()));
}

TrackedObject describe(const Track& track, const ObjectSnapshot& snapshot, int age) {
  TrackedObject out;
  out.id = track.id;
  out.number = snapshot.number;
  out.time = snapshot.time;
  out.points = static_cast<int>(snapshot.points_0.size());
  out.velocity_0 = track.filter.velocity();
  out.velocity_covariance_0 = track.filter.velocity_covariance();
  const Eigen::AlignedBox3d box = snapshot.box(out.velocity_0);
  out.centre_0 = box.center();
  out.extent_0 = box.sizes();
  out.age = age;
  return out;
}

}  // namespace

class ObjectTracker::Implementation {
 public:
  std::vector<TrackedObject> process(const Detection& detection, const Trajectory& trajectory,
                                     const std::shared_ptr<const RayImage>& rays) {
    const Time start = detection.scan->start;
    require_usable(detection, scans_ == 0 ? std::nullopt : std::optional(newest_start_));
    std::vector<ObjectSnapshot> snapshots = take_snapshots(detection, trajectory, rays);
    newest_start_ = start;
    drop_absent(start);
    const std::vector<Track*> tracks = tracks_of(snapshots, start);
    std::vector<TrackedObject> out(snapshots.size());
    // One task per object: every object has its own track.
    tbb::parallel_for(std::size_t{0}, snapshots.size(), [&](std::size_t s) {
      Track& track = *tracks[s];
      out[s] = update(track, snapshots[s]);
      track.keep(std::move(snapshots[s]));
      track.last_scan = start;
    });
    // After all of them: a part that split off shares snapshots with the whole, which may be in this scan,
    // too.
    for (Track* track : tracks) track->release_earlier_scan();
    ++scans_;
    return out;
  }

 private:
  void drop_absent(Time now) {
    const auto gone = [&](const Track& track) {
      return (now - track.last_scan).seconds() > kLongestAbsence_s;
    };
    tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), gone), tracks_.end());
  }

  // The track of each object, known or new. New ones begin before any is updated: a part that splits off
  // begins with the state of the whole before this scan.
  [[nodiscard]] std::vector<Track*> tracks_of(const std::vector<ObjectSnapshot>& snapshots, Time scan_start) {
    if (known_.size() < tracks_.size()) known_.resize(tracks_.size());
    if (seen_.size() < snapshots.size()) seen_.resize(snapshots.size());
    const std::span known = std::span(known_).first(tracks_.size()),
                    seen = std::span(seen_).first(snapshots.size());
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      const Track& track = tracks_[k];
      const double dt = (scan_start - track.last_scan).seconds();
      const double std_mps = std::sqrt(track.filter.velocity_covariance().diagonal().maxCoeff());
      predict(track.newest(), dt * track.filter.velocity(), dt * std_mps, known[k]);
      known[k].hidden_m = (track.diagonal_m - track.newest_diagonal_m()) / 2;
    }
    for (std::size_t s = 0; s < snapshots.size(); ++s) predict(snapshots[s], Vector3d::Zero(), 0, seen[s]);
    const Association association = associate(known, seen);
    std::vector<Track*> out;
    out.reserve(snapshots.size());
    for (std::size_t s = 0; s < snapshots.size(); ++s) {
      const auto& which = association.known[s];
      out.push_back(which ? &tracks_[*which] : &begin_track(snapshots[s], association.parent[s]));
    }
    return out;
  }

  Track& begin_track(const ObjectSnapshot& snapshot, const std::optional<std::size_t>& parent) {
    Track track = parent ? tracks_[*parent] : new_track(snapshot);
    if (parent) track.filter.loosen(kSplitStd_mps);
    track.id = next_id_++;
    track.first_scan = scans_;
    tracks_.push_back(std::move(track));
    return tracks_.back();
  }

  [[nodiscard]] static Track new_track(const ObjectSnapshot& snapshot) {
    const Matrix3d covariance = kNewTrackStd_mps * kNewTrackStd_mps * Matrix3d::Identity();
    return {0, 0, VelocityFilter(snapshot.time, Vector3d::Zero(), covariance, kAccelerationDensity), {}, {}};
  }

  [[nodiscard]] TrackedObject update(Track& track, const ObjectSnapshot& snapshot) const {
    if (!track.snapshots.empty()) observe(track, snapshot);
    return describe(track, snapshot, static_cast<int>(scans_ - track.first_scan) + 1);
  }

  std::deque<Track> tracks_;  // by increasing id; a deque's elements stay where they are when it grows
  std::vector<PredictedObject> known_, seen_;  // of this scan; kept for their memory
  std::uint32_t next_id_ = 1;
  std::size_t scans_ = 0;
  Time newest_start_;
};

ObjectTracker::ObjectTracker() : implementation_(std::make_unique<Implementation>()) {}
ObjectTracker::~ObjectTracker() = default;
ObjectTracker::ObjectTracker(ObjectTracker&&) noexcept = default;
ObjectTracker& ObjectTracker::operator=(ObjectTracker&&) noexcept = default;

std::vector<TrackedObject> ObjectTracker::process(const Detection& detection, const Trajectory& trajectory,
                                                  const std::shared_ptr<const RayImage>& rays) {
  return implementation_->process(detection, trajectory, rays);
}

}  // namespace mapless
