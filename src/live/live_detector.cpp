#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "core/time_check.hpp"
#include "live/cloud_queue.hpp"
#include "live/figures.hpp"
#include "live/health.hpp"
#include "live/live_frames.hpp"
#include "live/measurement_queue.hpp"
#include "live/scan_maker.hpp"
#include "live/transform_buffer.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/live/live_detector.hpp>

namespace mapless::inline v1 {
namespace {

// Detection begins anew after as many clouds in a row that cannot be used: at 10 Hz, a third of a second.
constexpr int kMostRefused = 3;
// Own odometry decides its start within 16 scans; where labels need longer, the computer is too slow.
constexpr double kLongestStart_s = 5;

Time steady_now() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return Time::from_nanoseconds(std::chrono::duration_cast<std::chrono::nanoseconds>(since).count());
}

void append(std::vector<LiveOutput>& all, std::vector<LiveOutput> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

}  // namespace

struct LiveDetector::State {
  State(const LiveOptions& o, std::function<Time()> clock)
      : options(o),
        now(clock ? std::move(clock) : steady_now),
        queue(o.live, o.topic),
        measurements(o.live),
        scans(o.sensor, o.topic, Duration::from_seconds(o.live.clock_offset_s)),
        online(std::make_unique<OnlineDetector>(o.detector)) {}

  void report(LiveLevel level, const std::string& kind, const std::string& text);  // with the lock held
  void add_measured(MeasurementQueue::Measured measured) {
    const std::lock_guard lock(mutex);
    const Time time = now();
    measurements.add(std::move(measured), queue.current_stamp(time), time, health);
  }

  // On the thread of process():
  void count_output(const LiveOutput& output);
  [[nodiscard]] std::optional<Arrival> take();
  std::vector<LiveOutput> process_cloud(Arrival arrival);
  std::vector<LiveOutput> push(const MadeScan& made);
  std::vector<LiveOutput> push_with(const MadeScan& made, const std::shared_ptr<const Trajectory>& given);
  std::vector<LiveOutput> push_waiting();
  void find_base(const MadeScan& made);
  void measure_motion(const MadeScan& made);
  std::vector<LiveOutput> begin_anew(bool forget_sensor);
  std::vector<LiveOutput> outputs(std::vector<LabelledScan> labelled);
  std::vector<LiveOutput> refused(const std::string& reason);
  [[nodiscard]] bool is_usable(const Arrival& arrival);
  std::vector<LiveOutput> begin_anew_if_other(const PointCloud2View& cloud, const std::string& jump);
  [[nodiscard]] std::optional<Duration> period(bool settled) const;

  const LiveOptions options;
  const std::function<Time()> now;

  mutable std::mutex mutex;  // of the members up to the empty line
  std::condition_variable changed;
  CloudQueue queue;
  Health health;
  TransformBuffer transforms;
  MeasurementQueue measurements;
  Figures figures;
  std::string sensor;
  bool transform_came = false, labels_came = false;

  ScanMaker scans;
  std::unique_ptr<OnlineDetector> online;
  std::deque<MadeScan> waiting_for_pose;
  std::deque<Arrival> pushed;  // and not labelled yet
  std::optional<Time> last_stamp, start_began;
  Time newest_arrival;  // of the clouds pushed
  int refused_in_a_row = 0;
  bool flushing = false;  // labels that waited for no cloud are made
  SE3 T_vb;               // sensor from base_frame
  bool base_known = false;
  SE3 T_w0, T_wv;  // world of the outputs from that of `online`; the last known pose
  std::uint32_t first_id = 0, last_id = 0, world_number = 0;
};

void LiveDetector::State::report(LiveLevel level, const std::string& kind, const std::string& text) {
  health.report(level, kind, text, now());
}

std::optional<Arrival> LiveDetector::State::take() {
  const std::lock_guard lock(mutex);
  if (queue.starting() && !queue.empty()) {
    const Time time = now();
    if (!start_began) start_began = time;
    if (labels_came) {
      queue.catch_up(time, health);
    } else if ((time - *start_began).seconds() > kLongestStart_s) {
      queue.end_start(time, health);
    }
  }
  return queue.take();
}

bool LiveDetector::State::is_usable(const Arrival& arrival) {
  const PointCloud2View& view = arrival.cloud.view;
  const std::lock_guard lock(mutex);
  try {
    require_time("topic " + options.topic, "header.stamp", view.stamp);
  } catch (const InputError& error) {
    report(LiveLevel::error, "unusable cloud", error.what());
    return false;
  }
  if (view.size() == 0)
    report(LiveLevel::warning, "empty cloud", "a cloud without points: see whether the sensor is covered");
  return view.size() > 0;
}

// Of the clouds that arrive. `settled`: only where it is known well.
std::optional<Duration> LiveDetector::State::period(bool settled) const {
  const std::lock_guard lock(mutex);
  return settled && !queue.period_settled() ? std::nullopt : queue.period();
}

std::vector<LiveOutput> LiveDetector::State::begin_anew_if_other(const PointCloud2View& cloud,
                                                                 const std::string& jump) {
  const std::string difference = scans.difference(cloud, period(true));
  if (jump.empty() && difference.empty()) return {};
  {
    const std::lock_guard lock(mutex);
    const std::string& reason = difference.empty() ? jump : difference;
    report(LiveLevel::warning, difference.empty() ? "time jump" : "other clouds",
           reason + ": detection begins anew");
  }
  return begin_anew(!difference.empty());
}

std::vector<LiveOutput> LiveDetector::State::process_cloud(Arrival arrival) {
  if (!is_usable(arrival)) return {};
  const Time stamp = arrival.cloud.view.stamp;
  const Duration step = last_stamp ? stamp - *last_stamp : Duration::from_nanoseconds(1);
  const std::string jump = queue.jump(step);
  std::vector<LiveOutput> done = begin_anew_if_other(arrival.cloud.view, jump);
  if (jump.empty() && step.nanoseconds() <= 0) {
    const std::string age = step.nanoseconds() == 0
                                ? "with the stamp of the one before"
                                : fmt::format("{:.3f} s older than the one before", -step.seconds());
    append(done, refused(fmt::format("a cloud {} is ignored: see whether two drivers publish on topic {}",
                                     age, options.topic)));
    return done;
  }
  last_stamp = stamp;
  std::vector<std::string> reasons;
  const auto made =
      scans.add(std::move(arrival), period(false), [&](const std::string& why) { reasons.push_back(why); });
  if (made.empty() && reasons.empty()) refused_in_a_row = 0;  // kept until the sensor is known
  for (const std::string& reason : reasons) append(done, refused(reason));
  for (const MadeScan& one : made) append(done, push(one));
  return done;
}

std::vector<LiveOutput> LiveDetector::State::refused(const std::string& reason) {
  {
    const std::lock_guard lock(mutex);
    ++figures.refused;
    report(LiveLevel::error, "unusable cloud", reason);
  }
  if (++refused_in_a_row < kMostRefused) return {};
  return begin_anew(true);
}

std::vector<LiveOutput> LiveDetector::State::push(const MadeScan& made) {
  {
    const std::lock_guard lock(mutex);
    if (sensor.empty()) {
      sensor = scans.sensor();
      health.add_event(LiveLevel::ok, fmt::format("sensor {}", sensor));
      for (const std::string& note : scans.notes()) health.add_event(LiveLevel::ok, note);
    }
    for (const std::string& one : made.doubts) report(LiveLevel::warning, one.substr(0, one.find(':')), one);
  }
  if (!options.poses_given()) {
    if (!base_known) find_base(made);
    measure_motion(made);
    return push_with(made, nullptr);
  }
  waiting_for_pose.push_back(made);
  return push_waiting();
}

// The world begins where the base was: from then on its axes are those of the base at the start.
void LiveDetector::State::find_base(const MadeScan& made) {
  if (options.base_frame.empty()) {
    base_known = true;
    return;
  }
  const std::lock_guard lock(mutex);
  const auto found = transforms.find(made.arrival.cloud.view.frame_id, options.base_frame, made.scan->start,
                                     made.scan->end());
  if (!found.trajectory) {
    report(LiveLevel::warning, "no base", found.reason + "; there is no odometry until there are");
    return;
  }
  base_known = true;
  T_vb = found.trajectory->at(made.scan->start).T_v0;
  T_w0 = T_vb.inverse() * T_w0;
  T_wv = T_vb.inverse() * T_wv;
}

// Those of before the first scan have no effect on the odometry.
void LiveDetector::State::measure_motion(const MadeScan& made) {
  const std::lock_guard lock(mutex);
  const std::vector<MotionMeasurement> taken = measurements.take(
      made.arrival.cloud.view.frame_id, made.scan->start, made.scan->end(), transforms, now(), health);
  for (const MotionMeasurement& measured : taken) online->add_measurement(measured);
  figures.measurements = measurements.used();
}

// The clouds whose poses are known now, in order; those that have waited too long are given up.
std::vector<LiveOutput> LiveDetector::State::push_waiting() {
  std::vector<LiveOutput> done;
  while (!waiting_for_pose.empty()) {
    const MadeScan made = waiting_for_pose.front();
    TransformBuffer::Lookup found;
    bool given_up = false;
    {
      const std::lock_guard lock(mutex);
      transform_came = false;
      found = transforms.find(made.arrival.cloud.view.frame_id, options.world_frame, made.scan->start,
                              made.scan->end());
      const bool waited = (now() - made.arrival.arrived).seconds() >= options.live.pose_wait_s;
      given_up = !found.trajectory && (found.over || waited);
      if (given_up) report(LiveLevel::error, "no pose", found.reason + "; the cloud is not labelled");
    }
    if (!found.trajectory && !given_up) return done;
    waiting_for_pose.pop_front();
    if (found.trajectory) append(done, push_with(made, found.trajectory));
  }
  return done;
}

std::vector<LiveOutput> LiveDetector::State::push_with(const MadeScan& made,
                                                       const std::shared_ptr<const Trajectory>& given) {
  pushed.push_back(made.arrival);
  newest_arrival = made.arrival.arrived;
  try {
    std::vector<LiveOutput> done = outputs(online->push(made.scan, given));
    refused_in_a_row = 0;
    return done;
  } catch (const Error& error) {
    pushed.pop_back();
    return refused(error.what());
  }
}

std::vector<LiveOutput> LiveDetector::State::begin_anew(bool forget_sensor) {
  flushing = true;
  std::vector<LiveOutput> done = outputs(online->flush());
  flushing = false;
  online = std::make_unique<OnlineDetector>(options.detector);
  pushed.clear();
  waiting_for_pose.clear();
  refused_in_a_row = 0;
  last_stamp.reset();
  start_began.reset();
  first_id = last_id;
  if (!options.poses_given()) T_w0 = T_wv;
  if (!options.poses_given()) ++world_number;
  if (forget_sensor) scans.forget_sensor();
  const std::lock_guard lock(mutex);
  if (forget_sensor) sensor.clear();
  labels_came = false;
  measurements.clear();
  queue.begin_start();
  return done;
}

std::vector<LiveOutput> LiveDetector::State::outputs(std::vector<LabelledScan> labelled) {
  std::vector<LiveOutput> done;
  for (LabelledScan& one : labelled) {
    for (TrackedObject& object : one.detection.tracked) {
      object.id += first_id;
      last_id = std::max(last_id, object.id);
    }
    const Arrival arrival = std::move(pushed.front());
    pushed.pop_front();
    if (one.odometry && one.odometry->outcome == ScanOutcome::restarted) ++world_number;
    if (one.odometry && !one.odometry->knots.empty()) T_wv = T_w0 * one.odometry->knots.back().T_v0.inverse();
    const std::string body = options.base_frame.empty() ? arrival.cloud.view.frame_id : options.base_frame;
    LiveOutput output{arrival.cloud, std::move(one), T_w0,       options.world_frame,
                      T_vb,          body,           base_known, (now() - newest_arrival).seconds(),
                      world_number};
    count_output(output);
    done.push_back(std::move(output));
  }
  return done;
}

void LiveDetector::State::count_output(const LiveOutput& output) {
  const std::lock_guard lock(mutex);
  if (!labels_came && start_began) figures.start_s = fmt::format("{:.2f}", (now() - *start_began).seconds());
  labels_came = true;
  figures.add(output, !queue.starting() && !flushing, now());
  if (!output.labelled.odometry) return;
  const std::string trouble = trouble_of(*output.labelled.odometry);
  if (trouble.empty()) return;
  report(output.labelled.motion_state() == MotionState::lost ? LiveLevel::error : LiveLevel::warning,
         "motion", trouble);
}

LiveDetector::LiveDetector(const LiveOptions& options, std::function<Time()> now) {
  require_within_bounds(options.live, "LiveDetector");
  require_frames(options);
  state_ = std::make_unique<State>(options, std::move(now));
}

LiveDetector::~LiveDetector() = default;

void LiveDetector::add_cloud(PointCloud2 cloud, std::uint64_t publisher) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->queue.add(std::move(cloud), publisher, state_->now(), state_->health);
  }
  state_->changed.notify_one();
}

void LiveDetector::add_transform(const std::string& parent, const std::string& child, Time time,
                                 const SE3& T_parent_child, bool is_static) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->transforms.add(parent, child, time, T_parent_child, is_static);
    state_->transform_came = state_->options.poses_given();
  }
  state_->changed.notify_one();
}

void LiveDetector::add_angular_velocity(const std::string& frame, Time time, const Eigen::Vector3d& angular) {
  state_->add_measured({frame, time, std::nullopt, angular});
}

void LiveDetector::add_twist(const std::string& frame, Time time, const Eigen::Vector3d& linear,
                             const Eigen::Vector3d& angular) {
  state_->add_measured({frame, time, linear, angular});
}

void LiveDetector::wait(Duration at_most) {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait_for(lock, std::chrono::nanoseconds(at_most.nanoseconds()),
                           [this] { return !state_->queue.empty() || state_->transform_came; });
}

std::vector<LiveOutput> LiveDetector::process() {
  std::vector<LiveOutput> done = state_->push_waiting();
  if (auto arrival = state_->take()) append(done, state_->process_cloud(*std::move(arrival)));
  bool idle = false;
  {
    const std::lock_guard lock(state_->mutex);
    state_->transform_came = false;
    idle = state_->queue.empty();
  }
  if (idle) append(done, state_->outputs(state_->online->catch_up()));
  return done;
}

std::vector<LiveOutput> LiveDetector::reset() { return state_->begin_anew(true); }

std::vector<LiveEvent> LiveDetector::take_events() {
  const std::lock_guard lock(state_->mutex);
  return state_->health.take_events();
}

LiveDiagnostics LiveDetector::diagnostics() const {
  const std::lock_guard lock(state_->mutex);
  const Time time = state_->now();
  const CloudQueue& queue = state_->queue;
  LiveDiagnostics d = {state_->health.level(time), state_->health.message(time),
                       queue.last_arrival().has_value(), state_->sensor, state_->figures.values(queue, time)};
  if (const auto silence = queue.silence(time)) {
    d.level = silence->level;
    d.message = silence->text;
  } else if (d.message.empty()) {
    d.message = state_->labels_came ? "labels clouds" : "starting";
  }
  return d;
}

}  // namespace mapless
