#include <string>
#include <utility>

#include "detection/detection_pipeline.hpp"
#include "detection/tracking/moving_objects.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>

namespace mapless::inline v1 {
namespace {

const DetectorParameters& checked(const DetectorParameters& parameters) {
  require_within_bounds(parameters, "Detector");
  return parameters;
}

}  // namespace

Detector::Detector(const DetectorParameters& parameters)
    : parameters_(checked(parameters)),
      pipeline_(parameters.method == DetectionMethod::voting ? make_voting_pipeline(parameters)
                                                             : make_published_pipeline(parameters)),
      moving_(std::make_unique<MovingObjects>(parameters)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

void Detector::learn_own_vehicle(const LidarScan& scan, const Trajectory& trajectory) {
  pipeline_->learn_own_vehicle(scan, trajectory);
}

std::vector<Detection> Detector::process(std::shared_ptr<const LidarScan> scan,
                                         const Trajectory& trajectory) {
  const Time start = scan->start;
  if (next_number_ > 0 && start <= newest_start_) {
    throw InputError({"scan " + std::to_string(next_number_), "start",
                      std::to_string(start.nanoseconds()) + " ns", "not after the scan before it",
                      "give scans by increasing time"});
  }
  pipeline_->add(std::move(scan), trajectory);
  newest_start_ = start;
  ++next_number_;
  std::vector<Detection> ready;
  if (next_number_ < first_detections_at()) return ready;
  while (next_detection_ + static_cast<std::size_t>(latency()) < next_number_) ready.push_back(next());
  return ready;
}

std::vector<Detection> Detector::flush() {
  std::vector<Detection> ready;
  while (next_detection_ < next_number_) ready.push_back(next());
  return ready;
}

void Detector::explain(std::function<bool(Time)> points) { pipeline_->explain(std::move(points)); }

std::vector<std::shared_ptr<const RayImage>> Detector::new_rays() {
  return pipeline_->rays_from(std::exchange(next_rays_, next_number_));
}

void Detector::add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays) {
  pipeline_->add_rays_of_another_sensor(std::move(rays));
}

std::size_t Detector::first_detections_at() const {
  const bool waits = parameters_.method == DetectionMethod::voting && latency() > 0;
  return waits ? static_cast<std::size_t>(parameters_.voting.start_scans) : 0;
}

Detection Detector::next() {
  Detection detection = moving_->classify(pipeline_->propose(next_detection_));
  detection.sequence_number = next_detection_++;
  return detection;
}

}  // namespace mapless
