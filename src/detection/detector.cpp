#include <string>
#include <utility>

#include "detection/detection_pipeline.hpp"
#include "detection/moving_objects.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>

namespace mapless {

Detector::Detector(const DetectorParameters& parameters)
    : parameters_(parameters),
      pipeline_(parameters.method == DetectionMethod::voting ? make_voting_pipeline(parameters)
                                                             : make_published_pipeline(parameters)),
      moving_(std::make_unique<MovingObjects>(parameters)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::optional<Detection> Detector::process(std::shared_ptr<const LidarScan> scan,
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
  const auto gap = static_cast<std::size_t>(parameters_.forward_gap);
  if (next_number_ <= next_detection_ + gap) return std::nullopt;
  if (gap == 0) return next(std::nullopt);
  return next(next_detection_ + gap);
}

std::optional<Detection> Detector::flush() {
  if (next_detection_ == next_number_) return std::nullopt;
  const std::size_t newest = next_number_ - 1;
  if (newest == next_detection_) return next(std::nullopt);
  return next(newest);
}

Detection Detector::next(std::optional<std::size_t> later) {
  ProposedObjects proposed = pipeline_->detect(next_detection_, later);
  proposed.detection.sequence_number = next_detection_++;
  return moving_->judge(std::move(proposed));
}

}  // namespace mapless
