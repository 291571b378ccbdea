#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "detection/segmentation/object_evidence.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// What a pipeline finds in a scan: every object it proposes has a number.
struct ProposedObjects {
  Detection detection;
  std::vector<TrajectoryState> column_states;  ///< of the sensor, CompensatedScan::column_states
  std::vector<ObjectEvidence> evidence;        ///< EvidenceGrowthResult::evidence
};

/// How scans are remembered and judged; Detector says when. Scans are numbered from 0 in the order they come.
class DetectionPipeline {
 public:
  virtual ~DetectionPipeline() = default;
  /// Takes the next scan. Throws TrajectoryDomainError, and has then not taken it.
  virtual void add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) = 0;
  /// The objects of scan `number`, with the help of those after it up to the newest there is. Scans come by
  /// increasing number, each once.
  virtual ProposedObjects detect(std::size_t number) = 0;
};

/// Freespace voting, and the five steps as published.
std::unique_ptr<DetectionPipeline> make_voting_pipeline(const DetectorParameters& parameters);
std::unique_ptr<DetectionPipeline> make_published_pipeline(const DetectorParameters& parameters);

}  // namespace mapless
