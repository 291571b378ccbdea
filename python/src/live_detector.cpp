#include "live_detector.hpp"

#include <iterator>

#include "options/parameter_options.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::python {
namespace {

// As many as the reader of a recording takes.
constexpr std::size_t kScansForSensor = 8;
const std::string kScan = "push()";

OnlineDetectorOptions options_of(const std::string& profile,
                                 const std::map<std::string, std::string>& settings) {
  app::RunParameters parameters = {detector_profile(profile), {}};
  const auto references = app::references_of(parameters);
  for (const auto& [key, text] : settings) assign_parameter(references, key, text, "OnlineDetector()");
  return {parameters.detector, parameters.odometry};
}

std::vector<std::uint32_t> ids_by_input(const LabelledScan& labelled) {
  std::map<std::uint16_t, std::uint32_t> ids;
  for (const TrackedObject& object : labelled.detection.tracked) ids[object.number] = object.id;
  std::vector<std::uint32_t> by_input(labelled.scan().input_size, 0);
  const auto numbers = labelled.object_by_input();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != 0) by_input[i] = ids[numbers[i]];
  }
  return by_input;
}

FoundScan found_of(LabelledScan& labelled) {
  const Detection& detection = labelled.detection;
  FoundScan found;
  found.scan = detection.sequence_number;
  found.stamp_ns = labelled.scan().start.nanoseconds();
  found.label = labels_of(detection, detection.tracked);
  found.object = ids_by_input(labelled);
  found.stages = stage_masks_of(detection);
  found.probability = labelled.probability_by_input();
  found.objects = detection.tracked;
  found.trajectory = labelled.trajectory;
  found.T_0v = labelled.T_0v();
  found.motion_state = labelled.motion_state();
  if (labelled.odometry) found.trouble = trouble_of(*labelled.odometry);
  return found;
}

std::vector<FoundScan> found_of(std::vector<LabelledScan> labelled) {
  std::vector<FoundScan> found;
  for (LabelledScan& scan : labelled) found.push_back(found_of(scan));
  return found;
}

}  // namespace

LiveDetector::LiveDetector(const std::string& sensor, std::optional<double> rotation_rate_hz,
                           const std::string& profile, const std::map<std::string, std::string>& settings)
    : detector_(options_of(profile, settings)), rotation_rate_hz_(rotation_rate_hz) {
  if (sensor.empty()) return;
  LidarModel model = model_from_name_or_file(sensor);
  if (rotation_rate_hz) model.rotation_rate_hz = *rotation_rate_hz;
  builder_.emplace(model);
}

std::vector<FoundScan> LiveDetector::push(Cloud cloud, std::shared_ptr<const Trajectory> given) {
  if (builder_) return push_built(cloud, given);
  waiting_.emplace_back(std::move(cloud), std::move(given));
  return waiting_.size() < kScansForSensor ? std::vector<FoundScan>() : recover();
}

std::vector<FoundScan> LiveDetector::push(const std::shared_ptr<const LidarScan>& scan,
                                          const std::shared_ptr<const Trajectory>& given) {
  std::vector<FoundScan> found = found_of(detector_.push(scan, given));
  watch_.add(*scan, watched_++);
  return found;
}

std::vector<FoundScan> LiveDetector::flush() {
  std::vector<FoundScan> found;
  if (!builder_ && !waiting_.empty()) found = recover();
  for (FoundScan& last : found_of(detector_.flush())) found.push_back(std::move(last));
  return found;
}

std::vector<std::string> LiveDetector::notes() const {
  return builder_ ? builder_->notes() : std::vector<std::string>();
}

std::vector<FoundScan> LiveDetector::push_built(const Cloud& cloud,
                                                const std::shared_ptr<const Trajectory>& given) {
  LidarScan scan = builder_->build(cloud.fields, cloud.stamp, kScan);
  scan.compensated_to = cloud.compensated_to;
  return push(std::make_shared<const LidarScan>(std::move(scan)), given);
}

// Where the sensor cannot be recovered, the scans that were kept are dropped.
std::vector<FoundScan> LiveDetector::recover() {
  const auto scans = std::exchange(waiting_, {});
  std::vector<PointFields> fields;
  std::vector<Time> stamps;
  for (const auto& [cloud, given] : scans) {
    fields.push_back(cloud.fields);
    stamps.push_back(cloud.stamp);
  }
  builder_ = ScanBuilder::recover(fields, stamps, kScan);
  if (rotation_rate_hz_) builder_->set_turn_duration(Duration::from_seconds(1 / *rotation_rate_hz_));
  std::vector<FoundScan> found;
  for (const auto& [cloud, given] : scans) {
    auto next = push_built(cloud, given);
    found.insert(found.end(), std::move_iterator(next.begin()), std::move_iterator(next.end()));
  }
  return found;
}

}  // namespace mapless::python
