#include <algorithm>
#include <deque>
#include <future>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <tbb/task_arena.h>

#include "core/argument_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/explanation.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::inline v1 {
namespace {

// Odometry decides the motion during the first scans after ten usable ones; a few unusable ones may come
// before them. Without a decision by then (no scan has enough points), detection goes on with the best
// trajectory there is.
constexpr std::size_t kMostScansHeldBack = 16;

// The estimated motion is kept from this long before the oldest scan without labels. Chosen: rays may fire
// before the start of their scan, and whoever takes the labels may ask for the motion a scan earlier.
const Duration kMotionKept = Duration::from_seconds(1);

std::vector<LabelledScan> joined(std::vector<LabelledScan> first, std::vector<LabelledScan> second) {
  std::move(second.begin(), second.end(), std::back_inserter(first));
  return first;
}

}  // namespace

std::vector<std::uint16_t> LabelledScan::object_by_input() const {
  std::vector<std::uint16_t> by_input(scan().input_size, 0);
  for (std::size_t i = 0; i < detection.object.size(); ++i)
    by_input[scan().returns[i].input_index] = detection.object[i];
  return by_input;
}

std::vector<float> LabelledScan::probability_by_input() const {
  std::vector<float> by_input(scan().input_size, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < detection.probability.size(); ++i)
    by_input[scan().returns[i].input_index] = detection.probability[i];
  return by_input;
}

struct OnlineDetector::State {
  using Scans = std::vector<std::shared_ptr<const LidarScan>>;

  // A scan pushed whose labels were not made yet.
  struct Unlabelled {
    Time start;
    std::shared_ptr<const Trajectory> given;  // null: estimated
    std::optional<OdometryUpdate> odometry;
  };
  // Dynamic points of a labelled scan, to be removed from the map of the odometry.
  struct DynamicPoints {
    std::shared_ptr<const LidarScan> scan;
    std::vector<std::uint16_t> object;  // Detection::object
  };

  explicit State(const OnlineDetectorOptions& o)
      : options(o), detector(o.detection), odometry(o.odometry), arena(arena_threads(o)) {
    detector.explain(options.explain);
  }

  static int arena_threads(const OnlineDetectorOptions& o) {
    require_between("OnlineDetector", "detection_threads", o.detection_threads, 0,
                    std::numeric_limits<int>::max());
    return o.detection_threads > 0 ? o.detection_threads : tbb::task_arena::automatic;
  }

  void require_same_source(bool given);
  std::vector<LabelledScan> push_given(const std::shared_ptr<const LidarScan>& scan,
                                       const std::shared_ptr<const Trajectory>& given);
  std::vector<LabelledScan> push_estimated(const std::shared_ptr<const LidarScan>& scan);
  OdometryUpdate register_beside_detection(const std::shared_ptr<const LidarScan>& scan);
  void remove_dynamic_points();
  void keep_unlabelled(const LidarScan& scan, OdometryUpdate update);
  std::vector<LabelledScan> detect(const Scans& scans, const Trajectory& trajectory);
  std::vector<LabelledScan> detect_one(const std::shared_ptr<const LidarScan>& scan,
                                       const Trajectory& trajectory);
  std::vector<LabelledScan> detect_registered(const Scans& scans);
  std::vector<LabelledScan> labelled(std::vector<Detection> detections);

  OnlineDetectorOptions options;
  Detector detector;
  std::size_t next_number = 0;                       // of the next scan to be labelled
  std::uint32_t last_id = 0;                         // the largest id of an object so far
  std::uint32_t detector_id = 0;                     // last_id when `detector` began
  std::uint32_t last_track = 0, detector_track = 0;  // the same of tracks, for explanations
  LidarOdometry odometry;
  OdometryReport report;
  tbb::task_arena arena;  // of the detection, where it runs side by side
  std::optional<bool> poses_given;

  std::deque<Unlabelled> unlabelled;            // in the order pushed
  Scans held_back;                              // the motion during them is not decided yet
  std::shared_ptr<const LidarScan> registered;  // its detection waits for the next push; or null
  std::shared_ptr<const Trajectory> estimated;  // as it was known after the newest scan
  std::vector<LabelledScan> ready;              // labelled, but a push that failed could not return them
  std::vector<DynamicPoints> dynamic_points;    // to be removed from the map after the next odometry
};

void OnlineDetector::State::require_same_source(bool given) {
  if (poses_given.value_or(given) == given) return;
  throw InputError(
      {"scan", "poses", given ? "given" : "not given",
       given ? "those of the scans before were estimated" : "those of the scans before were given",
       "give poses with every scan or with none"});
}

std::vector<LabelledScan> OnlineDetector::State::push_given(const std::shared_ptr<const LidarScan>& scan,
                                                            const std::shared_ptr<const Trajectory>& given) {
  std::shared_ptr<const LidarScan> measured = scan;
  if (scan->compensated_to)
    measured = std::make_shared<const LidarScan>(restore_measured_rays(*scan, *given));
  std::vector<Detection> detections = detector.process(measured, *given);
  poses_given = true;
  unlabelled.push_back({scan->start, given, std::nullopt});
  return labelled(std::move(detections));
}

std::vector<LabelledScan> OnlineDetector::State::push_estimated(
    const std::shared_ptr<const LidarScan>& scan) {
  OdometryUpdate update = register_beside_detection(scan);
  poses_given = false;
  report.add(*scan, update);
  remove_dynamic_points();
  keep_unlabelled(*scan, std::move(update));
  odometry.forget_before(unlabelled.front().start - kMotionKept);
  held_back.push_back(scan);
  std::vector<LabelledScan> done = std::exchange(ready, {});
  if (!odometry.started() && held_back.size() < kMostScansHeldBack) return done;
  estimated = odometry.trajectory_snapshot();
  if (options.side_by_side && held_back.size() == 1) {
    registered = std::move(held_back.front());
    held_back.clear();
    return done;
  }
  return joined(std::move(done), detect_registered(std::exchange(held_back, {})));
}

// Where odometry fails, the labels made beside it are kept for the next call.
OdometryUpdate OnlineDetector::State::register_beside_detection(
    const std::shared_ptr<const LidarScan>& scan) {
  std::future<std::vector<LabelledScan>> detection;
  if (const auto before = std::exchange(registered, nullptr)) {
    detection = std::async(std::launch::async, [this, before] {
      return arena.execute([&] { return detect({before}, *estimated); });
    });
  }
  const auto finish = [&] {
    if (detection.valid()) ready = joined(std::move(ready), detection.get());
  };
  try {
    OdometryUpdate update = odometry.process(scan);
    finish();
    return update;
  } catch (...) {
    finish();
    throw;
  }
}

void OnlineDetector::State::remove_dynamic_points() {
  for (const DynamicPoints& points : std::exchange(dynamic_points, {}))
    odometry.remove_dynamic_points(*points.scan, points.object);
}

// The state of the first scans is known with the scan that decides their motion.
void OnlineDetector::State::keep_unlabelled(const LidarScan& scan, OdometryUpdate update) {
  const MotionState state = update.state;
  const std::size_t decided = std::min(update.decided_scans, unlabelled.size() + 1);
  unlabelled.push_back({scan.start, nullptr, std::move(update)});
  for (auto one = unlabelled.end() - static_cast<std::ptrdiff_t>(decided); one != unlabelled.end(); ++one)
    one->odometry->state = state;
}

std::vector<LabelledScan> OnlineDetector::State::detect(const Scans& scans, const Trajectory& trajectory) {
  std::vector<LabelledScan> out;
  for (const auto& scan : scans) out = joined(std::move(out), detect_one(scan, trajectory));
  return out;
}

// A scan without motion gets no labels; it waits for nothing, and nothing waits for it.
std::vector<LabelledScan> OnlineDetector::State::detect_one(const std::shared_ptr<const LidarScan>& scan,
                                                            const Trajectory& trajectory) {
  const auto own = std::find_if(unlabelled.begin(), unlabelled.end(),
                                [&](const Unlabelled& one) { return one.start == scan->start; });
  const bool restarted = own->odometry->outcome == ScanOutcome::restarted;
  const bool lost = own->odometry->state == MotionState::lost;
  if (!restarted && !lost) return labelled(detector.process(scan, trajectory));
  std::vector<LabelledScan> out = labelled(detector.flush());
  if (restarted) {
    detector = Detector(options.detection);
    detector.explain(options.explain);
    detector_id = last_id;
    detector_track = last_track;
  }
  if (!lost) return joined(std::move(out), labelled(detector.process(scan, trajectory)));
  Detection none;
  none.scan = scan;
  none.trace.resize(scan->returns.size());
  none.object.resize(scan->returns.size(), 0);
  none.motion_known = false;
  std::vector<Detection> without_labels;
  without_labels.push_back(std::move(none));
  return joined(std::move(out), labelled(std::move(without_labels)));
}

// Several scans at once: odometry has just started, and its map holds the dynamic points of all of them.
std::vector<LabelledScan> OnlineDetector::State::detect_registered(const Scans& scans) {
  if (scans.empty()) return {};  // with given poses there is no estimated trajectory
  std::vector<LabelledScan> out = detect(scans, *estimated);
  if (scans.size() > 1) remove_dynamic_points();
  return out;
}

std::vector<LabelledScan> OnlineDetector::State::labelled(std::vector<Detection> detections) {
  std::vector<LabelledScan> out;
  for (Detection& detection : detections) {
    Unlabelled& scan = unlabelled.front();
    detection.sequence_number = next_number++;
    for (TrackedObject& object : detection.tracked) {
      object.id += detector_id;
      last_id = std::max(last_id, object.id);
    }
    if (detection.explanation) {
      for (ObjectDecision& one : detection.explanation->objects) {
        if (one.object.id != 0) one.object.id += detector_id;
        one.track += detector_track;
        last_track = std::max(last_track, one.track);
      }
    }
    if (!scan.given) dynamic_points.push_back({detection.scan, detection.object});
    auto update = scan.odometry ? std::make_shared<const OdometryUpdate>(*std::move(scan.odometry)) : nullptr;
    out.push_back({std::move(detection), scan.given ? std::move(scan.given) : estimated, std::move(update)});
    unlabelled.pop_front();
  }
  return out;
}

OnlineDetector::OnlineDetector(const OnlineDetectorOptions& options)
    : state_(std::make_unique<State>(options)) {}
OnlineDetector::~OnlineDetector() = default;
void OnlineDetector::learn_own_vehicle(const LidarScan& scan, const Trajectory& given) {
  state_->detector.learn_own_vehicle(scan, given);
}
void OnlineDetector::add_measurement(const MotionMeasurement& measured) {
  state_->odometry.add_measurement(measured);
}
OnlineDetector::OnlineDetector(OnlineDetector&&) noexcept = default;
OnlineDetector& OnlineDetector::operator=(OnlineDetector&&) noexcept = default;

std::vector<LabelledScan> OnlineDetector::push(const std::shared_ptr<const LidarScan>& scan,
                                               const std::shared_ptr<const Trajectory>& given) {
  state_->require_same_source(given != nullptr);
  return given ? state_->push_given(scan, given) : state_->push_estimated(scan);
}

std::vector<LabelledScan> OnlineDetector::push(LidarScan scan,
                                               const std::shared_ptr<const Trajectory>& given) {
  return push(std::make_shared<const LidarScan>(std::move(scan)), given);
}

std::vector<LabelledScan> OnlineDetector::catch_up() {
  std::vector<LabelledScan> done = std::exchange(state_->ready, {});
  if (const auto scan = std::exchange(state_->registered, nullptr))
    done = joined(std::move(done), state_->detect_registered({scan}));
  return done;
}

std::vector<LabelledScan> OnlineDetector::flush() {
  std::vector<LabelledScan> done = catch_up();
  if (state_->unlabelled.empty()) return done;
  if (!*state_->poses_given) state_->estimated = state_->odometry.trajectory_snapshot();
  done = joined(std::move(done), state_->detect_registered(std::exchange(state_->held_back, {})));
  return joined(std::move(done), state_->labelled(state_->detector.flush()));
}

std::vector<std::shared_ptr<const RayImage>> OnlineDetector::new_rays() {
  return state_->detector.new_rays();
}
void OnlineDetector::add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays) {
  state_->detector.add_rays_of_another_sensor(std::move(rays));
}
int OnlineDetector::latency() const { return state_->detector.latency(); }
const OdometryReport& OnlineDetector::odometry_report() const { return state_->report; }

}  // namespace mapless
