#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "detection/detection_pipeline.hpp"
#include "detection/evidence/collect_evidence.hpp"
#include "detection/evidence/reference_gaps.hpp"
#include "detection/freespace/open_sky.hpp"
#include "detection/freespace/range_noise.hpp"
#include "detection/own_vehicle.hpp"
#include "detection/segmentation/evidence_growth.hpp"
#include "detection/segmentation/explain_segmentation.hpp"
#include "detection/segmentation/slow_surfaces.hpp"
#include "geometry/sensor_motion.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {
namespace {

CandidateVerdict candidate(const PointEvidence& e) {
  if (e.seen_through || e.occluder_left) return CandidateVerdict::dynamic;
  return e.surface_seen ? CandidateVerdict::matched : CandidateVerdict::not_compared;
}

FreespaceVerdict sign_of(int votes) {
  if (votes == 0) return FreespaceVerdict::unobserved;
  return votes > 0 ? FreespaceVerdict::inside : FreespaceVerdict::border;
}

// Of a point on the own vehicle: as if every reference scan saw a surface there.
PointEvidence of_own_vehicle(std::size_t references) {
  PointEvidence evidence;
  evidence.past = static_cast<std::int16_t>(-kMaxSurfaceVotes * static_cast<int>(references));
  evidence.surface_seen = true;
  evidence.own_vehicle = true;
  return evidence;
}

std::vector<StageTrace> trace_of(const std::vector<PointEvidence>& evidence,
                                 const std::vector<FilterVerdict>& seeds,
                                 const std::vector<GrowthVerdict>& growth) {
  std::vector<StageTrace> trace(evidence.size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const PointEvidence& e = evidence[i];
    trace[i] = {candidate(e), sign_of(e.past), sign_of(e.total()), seeds[i], growth[i]};
  }
  return trace;
}

// Over which the velocity of the sensor is taken: as long as an object is registered over, 0.5 s at 10 Hz.
constexpr std::size_t kVelocityScans = 5;

// Scans of other sensors that are kept while this sensor delivers none: those of four sensors that are
// compared, and more.
constexpr std::size_t kMostOtherScans = 260;

// Where its lasers are farther apart than this many times those of the own sensor, another sensor misses what
// ends between two of them: VLP-16 for OS1-128, IoU -.0037 (docs/notebook/detection.md, "Several lidars").
constexpr double kWidestSpacing = 1.5;

// Mean angle between neighbouring lasers; of a single laser: infinite.
double laser_spacing_rad(const LidarModel& model) {
  if (model.lasers.size() < 2) return std::numeric_limits<double>::infinity();
  const double span = model.lasers.back().elevation_rad - model.lasers.front().elevation_rad;
  return span / static_cast<double>(model.lasers.size() - 1);
}

double duration_s(const LidarScan& scan) {
  return scan.column_period.seconds() * static_cast<double>(scan.columns);
}

class VotingPipeline final : public DetectionPipeline {
 public:
  explicit VotingPipeline(const DetectorParameters& parameters)
      : parameters_(parameters.voting),
        gaps_(reference_gaps(parameters.voting)),
        forward_gap_(static_cast<std::size_t>(parameters.forward_gap)) {}

  void learn_own_vehicle(const LidarScan& scan, const Trajectory& trajectory) override;
  void add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) override;
  ObjectProposals propose(std::size_t number) override;
  [[nodiscard]] std::vector<std::shared_ptr<const RayImage>> rays_from(std::size_t number) const override;
  void add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays) override;

 private:
  struct PendingScan {
    std::shared_ptr<const LidarScan> scan;
    LocalPoints points;
    std::vector<TrajectoryState> column_states;
    VotingParameters parameters;  // with the tolerance for its noise
    StageSeconds seconds;         // of its preparation
  };
  [[nodiscard]] const RayImage& image(std::size_t number) const { return *images_.at(number - first_image_); }
  [[nodiscard]] std::shared_ptr<const RayImage> rays_at(std::size_t number, int gap) const {
    return images_.at(static_cast<std::size_t>(static_cast<int>(number - first_image_) - gap));
  }
  [[nodiscard]] std::vector<ReferenceScan> references_of(std::size_t number) const;
  [[nodiscard]] Eigen::Vector3d sensor_velocity_0(std::size_t number) const;
  [[nodiscard]] std::vector<ReferenceScan> others_for(const LidarScan& scan) const;
  void forget_others_before(const LidarScan& scan);
  [[nodiscard]] ObjectProposals run_stages(PendingScan query, const std::vector<ReferenceScan>& references,
                                           const std::vector<ReferenceScan>& others,
                                           const RayImage& own) const;

  VotingParameters parameters_;
  OwnVehicle own_vehicle_;
  OpenSky open_sky_;
  std::vector<std::size_t> gaps_;                       // of the earlier scans, increasing
  std::size_t forward_gap_;                             // of the first later one
  std::deque<std::shared_ptr<RayImage>> images_;        // consecutive scans, oldest first
  std::size_t first_image_ = 0;                         // number of the oldest
  std::deque<PendingScan> pending_;                     // scans without proposals yet, oldest first
  std::deque<std::shared_ptr<const RayImage>> others_;  // of other sensors, in the order they came
};

void VotingPipeline::learn_own_vehicle(const LidarScan& scan, const Trajectory& trajectory) {
  (void)open_sky_.of_next(scan);
  const SensorMotion motion(scan, trajectory);  // the pose to the bit as in `add`
  if (motion.column_states.empty()) return;
  const double tolerance_m = with_tolerance_for_noise(parameters_, scan).tolerance_m;
  own_vehicle_.learn(scan, motion.column_states.front().T_v0, tolerance_m);
}

// Step 1 gives the trajectory; here every return and ray gets its own pose.
void VotingPipeline::add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) {
  PendingScan pending;
  auto [compensated, points] =
      timed(pending.seconds.compensation, [&] { return compensate_locally(std::move(scan), trajectory); });
  pending.scan = compensated.scan;
  pending.points = std::move(points);
  images_.push_back(std::make_shared<RayImage>(compensated, images_.empty() ? nullptr : images_.back().get(),
                                               open_sky_.of_next(*compensated.scan)));
  pending.column_states = std::move(compensated.column_states);
  pending.parameters = with_tolerance_for_noise(parameters_, *pending.scan);
  if (!pending.column_states.empty()) {
    own_vehicle_.learn(*pending.scan, pending.column_states.front().T_v0, pending.parameters.tolerance_m);
  }
  pending_.push_back(std::move(pending));
}

// Only the first scans, which have few earlier ones, have several later reference scans.
std::vector<ReferenceScan> VotingPipeline::references_of(std::size_t number) const {
  const std::size_t newest = first_image_ + images_.size() - 1;
  std::vector<ReferenceScan> references;
  references.reserve(gaps_.size() + (newest - number));
  for (const std::size_t gap : gaps_) {
    if (gap <= number) references.push_back({&image(number - gap), static_cast<int>(gap)});
  }
  if (references.empty() && number > 0) references.push_back({&image(0), static_cast<int>(number)});
  for (std::size_t later = std::min(number + forward_gap_, newest); later > number && later <= newest;
       ++later)
    references.push_back({&image(later), -static_cast<int>(later - number)});
  return references;
}

Eigen::Vector3d VotingPipeline::sensor_velocity_0(std::size_t number) const {
  const std::size_t scans = std::min(kVelocityScans, number - first_image_);
  if (scans == 0) return Eigen::Vector3d::Zero();
  const RayImage &now = image(number), &before = image(number - scans);
  return (now.origin_0() - before.origin_0()) / (now.start() - before.start()).seconds();
}

std::vector<std::shared_ptr<const RayImage>> VotingPipeline::rays_from(std::size_t number) const {
  const std::size_t known = number > first_image_ ? std::min(number - first_image_, images_.size()) : 0;
  return {images_.begin() + static_cast<std::ptrdiff_t>(known), images_.end()};
}

void VotingPipeline::add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays) {
  others_.push_back(std::move(rays));
  if (others_.size() > kMostOtherScans) others_.pop_front();
}

// Of all other sensors that are as dense the scans that begin one of the gaps before this one, to the nearest
// scan.
std::vector<ReferenceScan> VotingPipeline::others_for(const LidarScan& scan) const {
  std::vector<ReferenceScan> others;
  for (const auto& rays : others_) {
    const double gap = std::round((scan.start - rays->start()).seconds() / duration_s(scan));
    if (!(gap >= 1 && gap <= static_cast<double>(gaps_.back()))) continue;
    if (laser_spacing_rad(rays->model()) > kWidestSpacing * laser_spacing_rad(*scan.model)) continue;
    if (!std::binary_search(gaps_.begin(), gaps_.end(), static_cast<std::size_t>(gap))) continue;
    others.push_back({rays.get(), static_cast<int>(gap)});
  }
  return others;
}

void VotingPipeline::forget_others_before(const LidarScan& scan) {
  const double reach_s = (static_cast<double>(gaps_.back()) + 1) * duration_s(scan);
  std::erase_if(others_, [&](const auto& rays) { return (scan.start - rays->start()).seconds() > reach_s; });
}

ObjectProposals VotingPipeline::propose(std::size_t number) {
  PendingScan query = std::move(pending_.front());
  pending_.pop_front();
  const std::vector<ReferenceScan> references = references_of(number);
  forget_others_before(*query.scan);
  const std::vector<ReferenceScan> others = others_for(*query.scan);
  ObjectProposals proposed = run_stages(std::move(query), references, others, image(number));
  proposed.rays = images_.at(number - first_image_);
  proposed.sensor_velocity_0 = sensor_velocity_0(number);
  for (const ReferenceScan& r : references) proposed.references.push_back({rays_at(number, r.gap), r.gap});
  images_.at(number - first_image_)->mark_dynamic(*proposed.scan, proposed.object);
  while (first_image_ + gaps_.back() < number + 1) {  // the oldest reference scan of the next query scan
    images_.pop_front();
    ++first_image_;
  }
  return proposed;
}

ObjectProposals VotingPipeline::run_stages(PendingScan query, const std::vector<ReferenceScan>& references,
                                           const std::vector<ReferenceScan>& others,
                                           const RayImage& own) const {
  ObjectProposals out;
  out.seconds = query.seconds;
  out.scan = std::move(query.scan);
  out.column_states = std::move(query.column_states);
  ScanExplanation* recorded = nullptr;  // what is said of points
  if (explained_) {
    out.explanation = std::make_shared<ScanExplanation>();
    out.explanation->start = out.scan->start;
    out.explanation->points_recorded = explained_(out.scan->start);
    out.explanation->limits.tolerance_m = query.parameters.tolerance_m;
    out.explanation->limits.through_within_m = kSeenThroughWithin_m;
    if (out.explanation->points_recorded) recorded = out.explanation.get();
  }

  const std::vector<std::int32_t> own_vehicle =
      own_vehicle_.find(*out.scan, query.parameters.tolerance_m);  // returns on it

  // 2., 3. Comparison and freespace check of every point, against several earlier scans and a later one.
  auto evidence = timed(out.seconds.evidence, [&] {
    auto of_points =
        collect_evidence(*out.scan, query.points, references, own, query.parameters, recorded, others);
    for (const std::int32_t i : own_vehicle)
      of_points[static_cast<std::size_t>(i)] = of_own_vehicle(references.size());
    return of_points;
  });
  // 4. Border effects: points whose linked neighbours do not have evidence too.
  const auto seeds = timed(out.seconds.filter, [&] {
    forgive_slow_surfaces(*out.scan, query.points, parameters_, evidence);
    return filter_evidence(*out.scan, query.points, evidence, parameters_);
  });
  // 5. Clustering and region growth: whole objects.
  auto regions = timed(out.seconds.region_growth,
                       [&] { return grow_evidence(*out.scan, query.points, evidence, seeds, parameters_); });
  if (recorded) {
    explain_segmentation(*out.scan, query.points, evidence, regions, parameters_, *recorded);
    for (const std::int32_t i : own_vehicle) recorded->points[static_cast<std::size_t>(i)].own_vehicle = true;
  }
  out.trace = trace_of(evidence, seeds, regions.verdict);
  out.object = std::move(regions.object);
  out.objects = regions.objects;
  out.evidence = std::move(regions.evidence);
  out.faint = std::move(regions.faint);
  out.rims = std::move(regions.rims);
  out.votes = std::move(evidence);
  out.points = std::move(query.points);
  out.parameters = query.parameters;
  return out;
}

}  // namespace

std::unique_ptr<DetectionPipeline> make_voting_pipeline(const DetectorParameters& parameters) {
  return std::make_unique<VotingPipeline>(parameters);
}

}  // namespace mapless
