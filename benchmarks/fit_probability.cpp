#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>

#include "detection/detection_pipeline.hpp"
#include "detection/tracking/motion_probability.hpp"
#include "detection/tracking/moving_objects.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>

// Fits the weights of motion_probability to recordings with true labels and poses:
//
//     fit_probability RECORDING...
//
// Prints one line of weights for each ObjectMotion, as they stand in motion_probability.cpp: a logistic
// regression of the labels on probability_terms, every point counted once.

namespace mapless {
namespace {

constexpr int kBinsPerDoubling = 4;  // of the evidence
constexpr int kRounds = 30;          // of Newton's method; ten suffice
constexpr double kRidge = 1e-3;      // where a term is always 0

struct Count {
  double points = 0, moving = 0;
};
using Terms = std::array<int, 4>;  // probability_terms, the last one in bins
using Counts = std::array<std::map<Terms, Count>, kObjectMotions>;

void add(const MotionCues& cues, bool moves, Counts& counts) {
  const Eigen::Vector4d terms = probability_terms(cues);
  const Terms bin = {static_cast<int>(terms[0]), static_cast<int>(terms[1]), static_cast<int>(terms[2]),
                     static_cast<int>(std::lround(terms[3] * kBinsPerDoubling))};
  Count& count = counts[static_cast<std::size_t>(cues.state)][bin];
  ++count.points;
  count.moving += moves ? 1 : 0;
}

/// The detector of method "voting", with its evidence and decisions in view.
class OpenDetector {
 public:
  void process(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) {
    pipeline_->add(std::move(scan), trajectory);
    ++added_;
  }
  [[nodiscard]] bool ready(bool last) const {
    const auto start = static_cast<std::size_t>(parameters_.voting.start_scans);
    const std::size_t latency = last ? 0 : static_cast<std::size_t>(parameters_.forward_gap);
    return (last || added_ >= start) && next_ + latency < added_;
  }
  void count_next(const Dataset& dataset, Counts& counts) {
    ObjectProposals proposed = pipeline_->propose(next_);
    const std::vector<PointEvidence> votes = proposed.votes;
    const std::vector<std::uint16_t> object = proposed.object;
    const Detection detection = moving_.classify(std::move(proposed));
    const auto truth = dataset.read_labels(next_++);
    if (!truth) return;
    // The proposed object of each that moves: points that complete a body have its number in the detection
    // alone.
    std::vector<std::uint16_t> proposed_as(static_cast<std::size_t>(detection.objects) + 1, 0);
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (object[i] != 0 && moving_.motions()[object[i] - 1U].moves)
        proposed_as[detection.object[i]] = object[i];
    }
    for (std::size_t i = 0; i < votes.size(); ++i) {
      const MotionTruth motion = motion_of_label((*truth)[detection.scan->returns[i].input_index]);
      if (motion == MotionTruth::unknown) continue;
      const std::uint16_t number = detection.object[i] == 0 ? object[i] : proposed_as[detection.object[i]];
      const TrackMotion* of_object = number == 0 ? nullptr : &moving_.motions()[number - 1U];
      add(motion_cues(votes[i], of_object), motion == MotionTruth::moving, counts);
    }
  }

 private:
  DetectorParameters parameters_;
  std::unique_ptr<DetectionPipeline> pipeline_ = make_voting_pipeline(parameters_);
  MovingObjects moving_{parameters_};
  std::size_t added_ = 0, next_ = 0;
};

void count_recording(const Dataset& dataset, Counts& counts) {
  OpenDetector detector;
  for (std::size_t k = 0; k < dataset.size(); ++k) {
    detector.process(std::make_shared<const LidarScan>(dataset.read(k)), *dataset.trajectory());
    while (detector.ready(k + 1 == dataset.size())) detector.count_next(dataset, counts);
  }
}

Eigen::Vector4d fitted(const std::map<Terms, Count>& counts) {
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Vector4d gradient = -kRidge * weights;
    Eigen::Matrix4d information = kRidge * Eigen::Matrix4d::Identity();
    for (const auto& [bin, count] : counts) {
      const Eigen::Vector4d terms(bin[0], bin[1], bin[2], static_cast<double>(bin[3]) / kBinsPerDoubling);
      const double p = 1 / (1 + std::exp(-weights.dot(terms)));
      gradient += (count.moving - p * count.points) * terms;
      information += p * (1 - p) * count.points * terms * terms.transpose();
    }
    weights += information.ldlt().solve(gradient);
  }
  return weights;
}

int run(int argc, char** argv) {
  Counts counts;
  for (int a = 1; a < argc; ++a) count_recording(*open_dataset(argv[a]), counts);
  for (const auto& of_state : counts) {
    const Eigen::Vector4d w = fitted(of_state);
    fmt::print("    {{{:.2f}, {:.2f}, {:.2f}, {:.2f}}},\n", w[0], w[1], w[2], w[3]);
  }
  return 0;
}

}  // namespace
}  // namespace mapless

int main(int argc, char** argv) { return mapless::run(argc, argv); }
