#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include "detection/freespace/ray_image.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/explanation.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The rays of another scan. `gap` [scans]: how far before the scan of the proposals it lies; below 0 it is
/// later.
struct ReferenceRays {
  std::shared_ptr<const RayImage> rays;
  int gap = 1;
};

/// The objects of one scan before they are tracked: method "voting" still has to classify which of them move.
/// Vectors have one element per return of `scan`, unless stated otherwise.
struct ObjectProposals {
  std::shared_ptr<const LidarScan> scan;
  std::vector<StageTrace> trace;
  std::vector<std::uint16_t> object;  ///< 0 for static, else 1, 2, ...: one number per proposed object
  int objects = 0;
  std::vector<TrajectoryState> column_states;  ///< of the sensor, CompensatedScan::column_states
  std::shared_ptr<const RayImage> rays;        ///< of `scan`
  std::vector<ObjectEvidence> evidence;        ///< by object number - 1; empty for method "published"
  std::vector<PointEvidence> votes;            ///< empty for method "published"
  // Method "voting" alone:
  LocalPoints points;                     ///< of `scan`
  std::vector<ReferenceRays> references;  ///< that gave the evidence
  Eigen::Vector3d sensor_velocity_0 =
      Eigen::Vector3d::Zero();  ///< mean over the last five scans [m/s, frame 0]; 0 in the first scan
  VotingParameters parameters;  ///< with the tolerance for the noise of `scan`
  std::vector<std::vector<std::int32_t>> faint;  ///< EvidenceGrowthResult::faint
  std::vector<std::int32_t> rims;                ///< EvidenceGrowthResult::rims
  StageSeconds seconds;
  std::shared_ptr<ScanExplanation> explanation;  ///< null unless wanted: DetectionPipeline::explain
};

/// Whether the points of a scan, given by its start, are to be explained.
using ExplainedScans = std::function<bool(Time)>;

/// A detection method without its tracker: it keeps what it needs of each scan, and proposes the objects of a
/// scan once the later ones are there. Detector decides when. Scans are numbered from 0 in the order of
/// `add`.
class DetectionPipeline {
 public:
  virtual ~DetectionPipeline() = default;
  /// Detector::learn_own_vehicle.
  virtual void learn_own_vehicle(const LidarScan& scan, const Trajectory& trajectory) = 0;
  /// Takes the next scan. Throws TrajectoryDomainError, and has then not taken it.
  virtual void add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) = 0;
  /// The objects of scan `number`, using the scans after it up to the newest. Called by increasing number,
  /// once for each scan.
  virtual ObjectProposals propose(std::size_t number) = 0;
  /// The rays of the scans from `number` on, oldest first, as far as they are kept. Detector::new_rays.
  [[nodiscard]] virtual std::vector<std::shared_ptr<const RayImage>> rays_from(std::size_t number) const = 0;
  /// Detector::add_rays_of_another_sensor.
  virtual void add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays) = 0;
  /// Scans proposed from now on get an explanation, with that of their points where `points` says so.
  void explain(ExplainedScans points) { explained_ = std::move(points); }

 protected:
  ExplainedScans explained_;  // empty: nothing is explained
};

/// Freespace voting, and the five steps as published.
std::unique_ptr<DetectionPipeline> make_voting_pipeline(const DetectorParameters& parameters);
std::unique_ptr<DetectionPipeline> make_published_pipeline(const DetectorParameters& parameters);

}  // namespace mapless
