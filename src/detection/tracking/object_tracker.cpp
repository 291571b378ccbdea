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

// Standard deviation per axis of a velocity nothing is known about: traffic in a town has less than that,
// and on a highway not three times as much.
constexpr double kUnknownSpeed_mps = 15;
// White noise on acceleration, per axis [m^2/s^3]: what goes on changes by sqrt(0.5) = 0.7 m/s in a second.
// Of what brakes or turns the innovations show it, and the noise grows with them (VelocityFilter).
constexpr double kAccelerationDensity = 0.5;
constexpr std::size_t kMostSnapshots = VelocityFilter::kMostRemembered;  // earlier scans an object keeps
constexpr double kLongestInterval_s = 0.45;   // between scans that are registered: things turn and accelerate
constexpr double kShortestInterval_s = 0.01;  // an object cut by the seam may be there twice in a moment
constexpr std::size_t kYoung = 2;             // views of an object whose velocity is not well known yet
constexpr std::array kEnds = {0.02, 0.98};    // of the points: where an object ends
constexpr double kMisfit = 0.3;               // of a motion that others are tried against
// A start as near to another, or to what was found from that, would lead there too.
constexpr double kSameStart_m = 0.1;
constexpr double kBetter = 0.1;       // in misfit: then the one expected is wrong
constexpr double kWrongStd_mps = 10;  // of an expected velocity that is wrong
constexpr double kSplitStd_mps = 1;   // what comes off an object moves much as that does

struct Track {
  std::uint32_t id;
  std::size_t first_scan;
  VelocityFilter motion;
  // Newest first, as the motion remembers them. What comes off an object shares them with it.
  std::vector<std::shared_ptr<ObjectSnapshot>> views;
  Time last_scan;         // start of that of the newest view
  double diagonal_m = 0;  // of the largest box seen

  [[nodiscard]] const ObjectSnapshot& newest() const { return *views.front(); }
  [[nodiscard]] double newest_diagonal_m() const { return newest().seen_box.diagonal().norm(); }

  void keep(ObjectSnapshot view) {
    motion.remember(kMostSnapshots);
    views.reserve(kMostSnapshots);
    if (views.size() == kMostSnapshots) views.pop_back();
    views.insert(views.begin(), std::make_shared<ObjectSnapshot>(std::move(view)));
    diagonal_m = std::max(diagonal_m, newest_diagonal_m());
  }
  // A scan is not kept longer than needed.
  void forget_earlier_scan() {
    if (views.size() > 1) views[1]->sight.reset();
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

// The direction in which the points are spread most.
Vector3d longest_direction(const ObjectSnapshot& view) {
  Matrix3d squares = Matrix3d::Zero();
  for (const SurfaceSample& s : view.surface)
    squares += (s.p_0 - view.mean_0) * (s.p_0 - view.mean_0).transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(squares);
  return solver.eigenvectors().col(2);
}

// The places along `direction` that a few of the points do not reach, and that a few go beyond.
std::array<double, 2> ends_along(const ObjectSnapshot& view, const Vector3d& direction) {
  std::vector<double> places(view.points_0.size());
  std::transform(view.points_0.begin(), view.points_0.end(), places.begin(),
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

// Where to look for the velocity where nothing good is known: the shift of the mean, of the middle, of the
// foremost and of the hindmost end. What is seen of an object may grow at one end and stay at the other.
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

// Since the object was last seen. It is looked for anew where little is known of it yet, or where what was
// expected does not explain what is seen.
RegisteredMotion newest_motion(Track& track, const ObjectSnapshot& now) {
  const ObjectSnapshot& before = track.newest();
  RegisteredMotion best = register_snapshots(now, before, track.motion.velocity());
  const bool young = track.views.size() <= kYoung;
  if (!young && best.misfit < kMisfit) return best;
  const double expected = best.misfit;
  const double near_mps = kSameStart_m / (now.time - before.time).seconds();
  std::array<Vector3d, 9> known = {best.velocity_0};  // tried, and what was found from there
  std::size_t count = 1;
  for (const Vector3d& start : starts(now, before)) {
    const auto is_near = [&](const Vector3d& v) { return (start - v).squaredNorm() < near_mps * near_mps; };
    if (std::any_of(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(count), is_near)) continue;
    const RegisteredMotion found = register_snapshots(now, before, start);
    known[count++] = start;
    known[count++] = found.velocity_0;
    if (found.misfit < best.misfit) best = found;
  }
  if (best.misfit < expected - kBetter) track.motion.loosen(kWrongStd_mps);
  return best;
}

// A long time between two scans tells the velocity best, 0 where there is the newest alone.
std::size_t oldest_to_register(const Track& track, Time now) {
  std::size_t oldest = 0;
  for (std::size_t i = 1; i < track.views.size(); ++i) {
    if ((now - track.views[i]->time).seconds() <= kLongestInterval_s) oldest = i;
  }
  return oldest;
}

void observe(Track& track, const ObjectSnapshot& now) {
  const auto seconds_since = [&](std::size_t past) { return (now.time - track.views[past]->time).seconds(); };
  if (seconds_since(0) < kShortestInterval_s) return;
  const RegisteredMotion newest = newest_motion(track, now);
  track.motion.predict(now.time);
  const auto observe_motion = [&](std::size_t past, const RegisteredMotion& moved) {
    const double dt = seconds_since(past);
    track.motion.observe(past, moved.velocity_0 * dt, moved.covariance * dt * dt);
  };
  observe_motion(0, newest);
  if (const std::size_t oldest = oldest_to_register(track, now.time); oldest > 0)
    observe_motion(oldest, register_snapshots(now, *track.views[oldest], track.motion.velocity()));
}

TrackedObject described(const Track& track, const ObjectSnapshot& view, int age) {
  TrackedObject out;
  out.id = track.id;
  out.number = view.number;
  out.time = view.time;
  out.points = static_cast<int>(view.points_0.size());
  out.velocity_0 = track.motion.velocity();
  out.velocity_covariance_0 = track.motion.velocity_covariance();
  const Eigen::AlignedBox3d box = view.box(out.velocity_0);
  out.centre_0 = box.center();
  out.extent_0 = box.sizes();
  out.age = age;
  return out;
}

}  // namespace

class ObjectTracker::Implementation {
 public:
  std::vector<TrackedObject> process(const Detection& detection, const Trajectory& trajectory) {
    const Time start = detection.scan->start;
    require_usable(detection, scans_ == 0 ? std::nullopt : std::optional(newest_start_));
    std::vector<ObjectSnapshot> views = take_snapshots(detection, trajectory);
    newest_start_ = start;
    forget_absent(start);
    const std::vector<Track*> tracks = tracks_of(views, start);
    std::vector<TrackedObject> out(views.size());
    // Every object is a track of its own.
    tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t s) {
      Track& track = *tracks[s];
      out[s] = updated(track, views[s]);
      track.keep(std::move(views[s]));
      track.last_scan = start;
    });
    // After all: what came off shares the view with what it came off, which is seen in this scan too.
    for (Track* track : tracks) track->forget_earlier_scan();
    ++scans_;
    return out;
  }

 private:
  void forget_absent(Time now) {
    const auto gone = [&](const Track& track) {
      return (now - track.last_scan).seconds() > kLongestAbsence_s;
    };
    tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), gone), tracks_.end());
  }

  // Known ones or new ones. All of them before any is updated: a part that comes off begins as the whole was.
  [[nodiscard]] std::vector<Track*> tracks_of(const std::vector<ObjectSnapshot>& views, Time scan_start) {
    if (known_.size() < tracks_.size()) known_.resize(tracks_.size());
    if (seen_.size() < views.size()) seen_.resize(views.size());
    const std::span known = std::span(known_).first(tracks_.size()),
                    seen = std::span(seen_).first(views.size());
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      const Track& track = tracks_[k];
      const double dt = (scan_start - track.last_scan).seconds();
      const double std_mps = std::sqrt(track.motion.velocity_covariance().diagonal().maxCoeff());
      expect(track.newest(), dt * track.motion.velocity(), dt * std_mps, known[k]);
      known[k].hidden_m = (track.diagonal_m - track.newest_diagonal_m()) / 2;
    }
    for (std::size_t s = 0; s < views.size(); ++s) expect(views[s], Vector3d::Zero(), 0, seen[s]);
    const Association association = associate(known, seen);
    std::vector<Track*> out;
    out.reserve(views.size());
    for (std::size_t s = 0; s < views.size(); ++s) {
      const auto& which = association.known[s];
      out.push_back(which ? &tracks_[*which] : &begun(views[s], association.parent[s]));
    }
    return out;
  }

  Track& begun(const ObjectSnapshot& view, const std::optional<std::size_t>& parent) {
    Track track = parent ? tracks_[*parent] : fresh(view);
    if (parent) track.motion.loosen(kSplitStd_mps);
    track.id = next_id_++;
    track.first_scan = scans_;
    tracks_.push_back(std::move(track));
    return tracks_.back();
  }

  [[nodiscard]] static Track fresh(const ObjectSnapshot& view) {
    const Matrix3d covariance = kUnknownSpeed_mps * kUnknownSpeed_mps * Matrix3d::Identity();
    return {0, 0, VelocityFilter(view.time, Vector3d::Zero(), covariance, kAccelerationDensity), {}, {}};
  }

  [[nodiscard]] TrackedObject updated(Track& track, const ObjectSnapshot& view) const {
    if (!track.views.empty()) observe(track, view);
    return described(track, view, static_cast<int>(scans_ - track.first_scan) + 1);
  }

  std::deque<Track> tracks_;  // by increasing id; a deque's elements stay where they are when it grows
  std::vector<PredictedObject> known_, seen_;  // of the scan at work; kept for their memory
  std::uint32_t next_id_ = 1;
  std::size_t scans_ = 0;
  Time newest_start_;
};

ObjectTracker::ObjectTracker() : implementation_(std::make_unique<Implementation>()) {}
ObjectTracker::~ObjectTracker() = default;
ObjectTracker::ObjectTracker(ObjectTracker&&) noexcept = default;
ObjectTracker& ObjectTracker::operator=(ObjectTracker&&) noexcept = default;

std::vector<TrackedObject> ObjectTracker::process(const Detection& detection, const Trajectory& trajectory) {
  return implementation_->process(detection, trajectory);
}

}  // namespace mapless
