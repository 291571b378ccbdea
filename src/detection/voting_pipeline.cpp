#include <algorithm>
#include <deque>
#include <utility>

#include "detection/detection_pipeline.hpp"
#include "detection/evidence/point_evidence.hpp"
#include "detection/evidence/reference_gaps.hpp"
#include "detection/freespace/range_noise.hpp"
#include "detection/segmentation/evidence_growth.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {
namespace {

CandidateVerdict compared(const PointVotes& v) {
  if (v.seen_through || v.vacated) return CandidateVerdict::dynamic;
  return v.surface_seen ? CandidateVerdict::matched : CandidateVerdict::not_compared;
}

FreespaceVerdict freespace(int votes) {
  if (votes == 0) return FreespaceVerdict::unobserved;
  return votes > 0 ? FreespaceVerdict::inside : FreespaceVerdict::border;
}

std::vector<StageTrace> recorded(const std::vector<PointVotes>& votes,
                                 const std::vector<FilterVerdict>& seeds,
                                 const std::vector<GrowthVerdict>& growth) {
  std::vector<StageTrace> trace(votes.size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const PointVotes& v = votes[i];
    trace[i] = {compared(v), freespace(v.earlier), freespace(v.total()), seeds[i], growth[i]};
  }
  return trace;
}

class VotingPipeline final : public DetectionPipeline {
 public:
  explicit VotingPipeline(const DetectorParameters& parameters)
      : parameters_(parameters.voting),
        gaps_(reference_gaps(parameters.voting)),
        forward_gap_(static_cast<std::size_t>(parameters.forward_gap)) {}

  void add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) override;
  ProposedObjects detect(std::size_t number) override;

 private:
  struct PendingScan {
    std::shared_ptr<const LidarScan> scan;
    LocalPoints points;
    std::vector<TrajectoryState> column_states;
    StageSeconds seconds;  // of its preparation
  };
  [[nodiscard]] const RayImage& image(std::size_t number) const { return images_.at(number - first_image_); }
  [[nodiscard]] std::vector<AskedScan> scans_to_ask(std::size_t number) const;
  [[nodiscard]] ProposedObjects judge(PendingScan query, const std::vector<AskedScan>& asked,
                                      const RayImage& own) const;

  VotingParameters parameters_;
  std::vector<std::size_t> gaps_;    // of the earlier scans, increasing
  std::size_t forward_gap_;          // of the first later one
  std::deque<RayImage> images_;      // consecutive scans, oldest first
  std::size_t first_image_ = 0;      // number of the oldest
  std::deque<PendingScan> pending_;  // scans not judged yet, oldest first
};

// Step 1 gives the poses; here every return and ray gets its own.
void VotingPipeline::add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) {
  PendingScan pending;
  auto [compensated, points] =
      timed(pending.seconds.compensation, [&] { return compensate_locally(std::move(scan), trajectory); });
  pending.scan = compensated.scan;
  pending.points = std::move(points);
  images_.emplace_back(compensated, images_.empty() ? nullptr : &images_.back());
  pending.column_states = std::move(compensated.column_states);
  pending_.push_back(std::move(pending));
}

// Later scans are several for the first scans alone, which have few earlier ones.
std::vector<AskedScan> VotingPipeline::scans_to_ask(std::size_t number) const {
  const std::size_t newest = first_image_ + images_.size() - 1;
  std::vector<AskedScan> asked;
  asked.reserve(gaps_.size() + (newest - number));
  for (const std::size_t gap : gaps_) {
    if (gap <= number) asked.push_back({&image(number - gap), static_cast<int>(gap)});
  }
  if (asked.empty() && number > 0) asked.push_back({&image(0), static_cast<int>(number)});
  for (std::size_t later = std::min(number + forward_gap_, newest); later > number && later <= newest;
       ++later)
    asked.push_back({&image(later), -static_cast<int>(later - number)});
  return asked;
}

ProposedObjects VotingPipeline::detect(std::size_t number) {
  PendingScan query = std::move(pending_.front());
  pending_.pop_front();
  ProposedObjects proposed = judge(std::move(query), scans_to_ask(number), image(number));
  images_.at(number - first_image_).mark_dynamic(*proposed.detection.scan, proposed.detection.object);
  while (first_image_ + gaps_.back() < number + 1) {  // the oldest the next detection can ask for
    images_.pop_front();
    ++first_image_;
  }
  return proposed;
}

ProposedObjects VotingPipeline::judge(PendingScan query, const std::vector<AskedScan>& asked,
                                      const RayImage& own) const {
  Detection out;
  out.seconds = query.seconds;
  out.scan = std::move(query.scan);

  // 2., 3. Comparison and freespace check, of every point, against several earlier scans and a later one.
  const auto votes = timed(out.seconds.backward, [&] {
    return collect_votes(*out.scan, query.points, asked, own, for_noise_of(*out.scan, parameters_));
  });
  // 4. Border effects have no neighbours that say the same.
  const auto seeds = timed(out.seconds.box_filter,
                           [&] { return filter_evidence(*out.scan, query.points, votes, parameters_); });
  // 5. Clustering and region growth: whole objects.
  auto regions = timed(out.seconds.region_growth,
                       [&] { return grow_evidence(*out.scan, query.points, votes, seeds, parameters_); });
  out.trace = recorded(votes, seeds, regions.verdict);
  out.object = std::move(regions.object);
  out.objects = regions.objects;
  return {std::move(out), std::move(query.column_states), std::move(regions.evidence)};
}

}  // namespace

std::unique_ptr<DetectionPipeline> make_voting_pipeline(const DetectorParameters& parameters) {
  return std::make_unique<VotingPipeline>(parameters);
}

}  // namespace mapless
