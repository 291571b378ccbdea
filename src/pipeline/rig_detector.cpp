#include <algorithm>
#include <deque>
#include <optional>
#include <set>
#include <utility>

#include "core/argument_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {
namespace {

// Scans of two sensors that turn together end microseconds apart, by the rounding of their column periods. So
// far the estimated motion is extrapolated. Chosen: half a turn at 10 Hz.
const Duration kExtrapolated = Duration::from_seconds(0.05);

// Scans of the first sensor whose motion is remembered, for the scans of others that wait: the detections at
// the start come together, and are some 20.
constexpr std::size_t kRemembered = 64;

std::vector<RigSensor> checked(std::vector<RigSensor> sensors) {
  if (sensors.empty()) throw ParameterError({"RigDetector", "sensors", "0", "none", "give at least one"});
  std::set<std::string> names;
  for (const RigSensor& sensor : sensors) {
    if (sensor.name.empty() || !names.insert(sensor.name).second)
      throw ParameterError({"RigDetector", "name", sensor.name,
                            sensor.name.empty() ? "empty" : "not the only one",
                            "give each sensor a name of its own"});
  }
  if (const Duration offset = sensors.front().clock_offset; offset != Duration()) {
    throw ParameterError({"RigDetector", "clock_offset", std::to_string(offset.seconds()) + " s",
                          "not 0 for the first sensor", "the clock of the rig is that of its first sensor"});
  }
  return sensors;
}

OnlineDetectorOptions one_after_another(OnlineDetectorOptions options) {
  options.side_by_side = false;
  return options;
}

// The scan with its times on the clock of the rig.
std::shared_ptr<const LidarScan> on_rig_clock(std::shared_ptr<const LidarScan> scan, Duration offset) {
  if (offset == Duration()) return scan;
  auto shifted = std::make_shared<LidarScan>(*scan);
  shifted->start = shifted->start + offset;
  if (shifted->compensated_to) shifted->compensated_to = *shifted->compensated_to + offset;
  return shifted;
}

Time middle(const LidarScan& scan) { return scan.column_time(scan.columns / 2); }

LabelledScan without_labels(std::shared_ptr<const LidarScan> scan,
                            std::shared_ptr<const Trajectory> trajectory) {
  LabelledScan out;
  out.detection.trace.resize(scan->returns.size());
  out.detection.object.resize(scan->returns.size(), 0);
  out.detection.motion_known = false;
  const bool covered = trajectory && trajectory->begin() <= scan->start && scan->end() <= trajectory->end();
  out.trajectory = covered ? std::move(trajectory) : nullptr;
  out.detection.scan = std::move(scan);
  return out;
}

}  // namespace

struct RigDetector::State {
  struct Member {
    explicit Member(const OnlineDetectorOptions& options) : online(options) {}
    OnlineDetector online;
    std::deque<std::shared_ptr<const LidarScan>> waiting;  // for the motion, in the order pushed
    std::optional<Time> newest_start;
    std::size_t next_number = 0;              // of the next scan to be labelled
    std::uint32_t last_id = 0, world_id = 0;  // the largest id so far, and before this world began
  };
  // The motion during a labelled scan of the first sensor.
  struct Motion {
    Time start, end;
    bool known;
    std::shared_ptr<const Trajectory> trajectory;
  };

  State(std::vector<RigSensor> s, const OnlineDetectorOptions& o)
      : sensors(checked(std::move(s))), options(one_after_another(o)) {
    for (std::size_t k = 0; k < sensors.size(); ++k) members.emplace_back(options);
  }

  void require_next(std::size_t sensor, const LidarScan& scan, bool given) const;
  [[nodiscard]] SE3 from_first(std::size_t sensor) const {
    return sensors[sensor].T_bv.inverse() * sensors.front().T_bv;
  }
  void detect(std::size_t sensor, const std::shared_ptr<const LidarScan>& scan,
              const std::shared_ptr<const Trajectory>& given, std::vector<RigScan>& out);
  void detect_waiting(std::size_t sensor, bool last, std::vector<RigScan>& out);
  [[nodiscard]] const Motion* motion_during(const LidarScan& scan) const;
  void begin_new_world(std::vector<RigScan>& out);
  void take(std::size_t sensor, std::vector<LabelledScan> labelled, std::vector<RigScan>& out);
  void give_up(std::size_t sensor, std::vector<RigScan>& out);
  [[nodiscard]] std::shared_ptr<const Trajectory> newest_motion(std::size_t sensor) const;
  void share_rays(std::size_t sensor);

  std::vector<RigSensor> sensors;
  OnlineDetectorOptions options;
  std::vector<Member> members;
  std::optional<bool> poses_given;
  std::deque<Motion> motions;  // of the first sensor where it is estimated, oldest first
  std::size_t worlds = 0;      // maps that odometry has begun after a loss
};

void RigDetector::State::require_next(std::size_t sensor, const LidarScan& scan, bool given) const {
  if (poses_given.value_or(given) != given) {
    throw InputError({"scan", "poses", given ? "given" : "not given", "not as with the scans before",
                      "give poses with every scan or with none"});
  }
  if (!given && scan.compensated_to) {
    throw InputError({"scan", "points", "", "compensated for motion already",
                      "odometry needs them as measured: give the poses they were compensated with"});
  }
  const std::optional<Time>& before = members[sensor].newest_start;
  if (before && scan.start <= *before) {
    throw InputError({"scan of " + sensors[sensor].name, "start",
                      std::to_string(scan.start.nanoseconds()) + " ns", "not after the scan before it",
                      "give the scans of a sensor by increasing time"});
  }
}

void RigDetector::State::detect(std::size_t sensor, const std::shared_ptr<const LidarScan>& scan,
                                const std::shared_ptr<const Trajectory>& given, std::vector<RigScan>& out) {
  std::vector<LabelledScan> labelled = members[sensor].online.push(scan, given);
  if (const std::size_t begun = members.front().online.odometry_report().restarts().size(); begun > worlds) {
    worlds = begun;
    begin_new_world(out);
  }
  take(sensor, std::move(labelled), out);
  share_rays(sensor);
}

void RigDetector::State::share_rays(std::size_t sensor) {
  for (const auto& rays : members[sensor].online.new_rays()) {
    for (std::size_t k = 0; k < members.size(); ++k) {
      if (k != sensor) members[k].online.add_rays_of_another_sensor(rays);
    }
  }
}

void RigDetector::State::take(std::size_t sensor, std::vector<LabelledScan> labelled,
                              std::vector<RigScan>& out) {
  Member& member = members[sensor];
  for (LabelledScan& one : labelled) {
    one.detection.sequence_number = member.next_number++;
    for (TrackedObject& object : one.detection.tracked) {
      object.id += member.world_id;
      member.last_id = std::max(member.last_id, object.id);
    }
    if (sensor == 0 && !*poses_given) {
      motions.push_back({one.scan().start, one.scan().end(), one.detection.motion_known, one.trajectory});
      if (motions.size() > kRemembered) motions.pop_front();
    }
    out.push_back({sensor, std::move(one)});
  }
}

// The first sensor's detector has begun anew by itself.
void RigDetector::State::begin_new_world(std::vector<RigScan>& out) {
  for (std::size_t k = 1; k < members.size(); ++k) {
    Member& member = members[k];
    take(k, member.online.flush(), out);
    while (!member.waiting.empty()) give_up(k, out);
    member.online = OnlineDetector(options);
    member.world_id = member.last_id;
  }
}

// The first of the scans that wait gets no labels, after those before it.
void RigDetector::State::give_up(std::size_t sensor, std::vector<RigScan>& out) {
  Member& member = members[sensor];
  take(sensor, member.online.flush(), out);
  std::vector<LabelledScan> unknown;
  unknown.push_back(without_labels(std::move(member.waiting.front()), newest_motion(sensor)));
  member.waiting.pop_front();
  take(sensor, std::move(unknown), out);
}

// Of the sensor, as far as the scans of the first one that are labelled show it; null: not at all.
std::shared_ptr<const Trajectory> RigDetector::State::newest_motion(std::size_t sensor) const {
  if (motions.empty()) return nullptr;
  return std::make_shared<const MountedTrajectory>(motions.back().trajectory, from_first(sensor),
                                                   kExtrapolated);
}

// The last scan of the first sensor that begins before the middle of the scan; null: none.
const RigDetector::State::Motion* RigDetector::State::motion_during(const LidarScan& scan) const {
  const auto after = std::find_if(motions.begin(), motions.end(),
                                  [&](const Motion& motion) { return motion.start > middle(scan); });
  return after == motions.begin() ? nullptr : &*std::prev(after);
}

// `last`: no more scans of the first sensor are to come.
void RigDetector::State::detect_waiting(std::size_t sensor, bool last, std::vector<RigScan>& out) {
  Member& member = members[sensor];
  while (!member.waiting.empty()) {
    const std::shared_ptr<const LidarScan> scan = member.waiting.front();
    const bool crowded = last || member.waiting.size() > kMostWaiting;
    if (motions.empty() || motions.back().end < middle(*scan)) {
      if (!crowded) return;
      give_up(sensor, out);
      continue;
    }
    const auto along = newest_motion(sensor);
    const Motion* const during = motion_during(*scan);
    const bool known = during != nullptr && during->known && along->begin() <= scan->start;
    if (known && along->end() < scan->end() && !crowded) return;
    if (!known || along->end() < scan->end()) {
      give_up(sensor, out);
      continue;
    }
    member.waiting.pop_front();
    detect(sensor, scan, along, out);
  }
}

RigDetector::RigDetector(std::vector<RigSensor> sensors, const OnlineDetectorOptions& options)
    : state_(std::make_unique<State>(std::move(sensors), options)) {}
RigDetector::~RigDetector() = default;
RigDetector::RigDetector(RigDetector&&) noexcept = default;
RigDetector& RigDetector::operator=(RigDetector&&) noexcept = default;

std::vector<RigScan> RigDetector::push(std::size_t sensor, std::shared_ptr<const LidarScan> scan,
                                       const std::shared_ptr<const Trajectory>& given) {
  require_given("RigDetector", "scan", scan.get());
  require_between("RigDetector", "sensor", static_cast<int>(sensor), 0,
                  static_cast<int>(state_->sensors.size()) - 1);
  scan = on_rig_clock(std::move(scan), state_->sensors[sensor].clock_offset);
  state_->require_next(sensor, *scan, given != nullptr);
  State::Member& member = state_->members[sensor];
  std::vector<RigScan> out;
  const std::optional<bool> before = std::exchange(state_->poses_given, given != nullptr);
  try {
    if (sensor == 0) {
      state_->detect(0, scan, given, out);
    } else if (given) {
      state_->detect(sensor, scan,
                     std::make_shared<const MountedTrajectory>(given, state_->from_first(sensor)), out);
    } else {
      member.waiting.push_back(scan);
    }
  } catch (...) {
    state_->poses_given = before;
    throw;
  }
  member.newest_start = scan->start;
  for (std::size_t k = 1; k < state_->members.size(); ++k) state_->detect_waiting(k, false, out);
  return out;
}

std::vector<RigScan> RigDetector::flush() {
  std::vector<RigScan> out;
  for (std::size_t k = 0; k < state_->members.size(); ++k) {
    if (k > 0) state_->detect_waiting(k, true, out);
    state_->take(k, state_->members[k].online.flush(), out);
    state_->share_rays(k);
  }
  return out;
}

const std::vector<RigSensor>& RigDetector::sensors() const { return state_->sensors; }
const OdometryReport& RigDetector::odometry_report() const {
  return state_->members.front().online.odometry_report();
}

}  // namespace mapless
