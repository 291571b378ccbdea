#include "explain/replayed_run.hpp"

#include <set>

#include <fmt/format.h>

#include "reports/json.hpp"
#include "run/earlier_run.hpp"
#include "run/given_motion.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

Json summary_of(const ResultFolder& result) {
  const Json json = Json::parse(read_whole_file(result.summary()), nullptr, false);
  if (json.is_object() && json.value("program", "") == kProgramName) return json;
  throw InputError({result.summary().string(), "program", "", "is not a summary of mapless detect",
                    "give the result of mapless detect as OUT"});
}

// Reads the values of the run, which may be of another profile than the default one.
RunParameters parameters_of(const ResultFolder& result) {
  ParameterOptions options;
  options.config = result.config().string();
  return options.all();
}

TrajectorySource motion_of(const Json& summary, const Dataset& dataset, const GivenAgain& given,
                           std::size_t first) {
  const std::string source = summary.value("trajectory", Json::object()).value("source", "");
  if (source == kEstimatedMotion) return motion_by_odometry(dataset, first);
  TrajectoryRequest request = given.trajectory;
  request.stationary = request.stationary || source == "stationary sensor";
  return open_trajectory(dataset, request);
}

}  // namespace

ReplayedRun::ReplayedRun(const Dataset& dataset, const ResultFolder& result, const GivenAgain& given)
    : dataset_(dataset), result_(result), parameters_(parameters_of(result)) {
  const Json summary = summary_of(result);
  const std::string file = result.summary().string();
  if (parameters_.detector.method == DetectionMethod::published) {
    throw ParameterError({result.config().string(), "method", "published",
                          "points are explained for method voting alone",
                          "the stages of a point are in stages/NNNNNN.stages"});
  }
  if (summary.value("version", "") != MAPLESS_VERSION) {
    throw InputError({file, "version", summary.value("version", ""), "is not " MAPLESS_VERSION,
                      "label the recording with this version"});
  }
  first_ = summary.value("first_scan", std::size_t{0});
  count_ = summary.value("selected_scans", std::size_t{0});
  if (count_ == 0 || first_ + count_ > dataset.size()) {
    throw InputError({file, "selected_scans", std::to_string(count_), "more scans than the recording has",
                      "give the recording from which this result was made"});
  }
  const TrajectorySource motion = motion_of(summary, dataset, given, first_);
  trajectory_ = motion.trajectory;
  measured_ = given.measured.measurements(dataset, first_, count_);
  if (recording_digest(dataset, trajectory_.get(), measured_, first_, count_) !=
      summary.value("recording_digest", "")) {
    throw InputError({file, "recording_digest", summary.value("recording_digest", ""),
                      "the recording or the poses are not those of this result",
                      "give the recording and the options of that run: --trajectory, --speed and so on"});
  }
}

void ReplayedRun::run(std::size_t last, const std::function<bool(std::size_t)>& explained,
                      const std::function<void(std::size_t, const LabelledScan&)>& take) const {
  std::set<Time> wanted;
  OnlineDetectorOptions options{parameters_.detector, parameters_.odometry};
  options.explain = [&](Time start) { return wanted.contains(start); };
  OnlineDetector online(options);
  for (const MotionMeasurement& one : measured_) online.add_measurement(one);
  std::size_t next = first_;
  const auto finish = [&](const std::vector<LabelledScan>& scans) {
    for (const LabelledScan& scan : scans) {
      if (next <= last) {
        require_same_labels(next, scan);
        take(next, scan);
      }
      ++next;
    }
  };
  for (std::size_t k = first_; k < first_ + count_ && next <= last; ++k) {
    auto scan = std::make_shared<const LidarScan>(dataset_.read(k));
    if (explained(k)) wanted.insert(scan->start);
    finish(online.push(std::move(scan), trajectory_));
  }
  if (next <= last) finish(online.flush());
}

void ReplayedRun::require_same_labels(std::size_t k, const LabelledScan& scan) const {
  const std::vector<std::uint32_t> now = labels_of(scan.detection, scan.detection.tracked);
  const std::vector<std::uint32_t> before = read_label_file(result_.label_file(k), now.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < now.size(); ++i) different += now[i] == before[i] ? 0U : 1U;
  if (different == 0) return;
  throw InputError({result_.label_file(k).string(), "labels",
                    fmt::format("{} of {} points", different, now.size()),
                    "are not those that this program computes, so it cannot explain them",
                    "label the recording again with this build; a result of --realtime, which drops scans, "
                    "cannot be explained"});
}

}  // namespace mapless::app
