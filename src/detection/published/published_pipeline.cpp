#include <deque>
#include <utility>

#include "detection/detection_pipeline.hpp"
#include "detection/published/box_filter.hpp"
#include "detection/published/freespace_check.hpp"
#include "detection/published/pointcloud_comparison.hpp"
#include "detection/published/prepared_scan.hpp"
#include "detection/published/region_growth.hpp"
#include "detection/published/stage_record.hpp"
#include "geometry/nearest_neighbours.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {
namespace {

template <class Condition>
std::vector<std::int32_t> points_where(const std::vector<StageTrace>& trace, Condition&& condition) {
  std::vector<std::int32_t> indices;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    if (condition(trace[i])) indices.push_back(static_cast<std::int32_t>(i));
  }
  return indices;
}

void record(std::vector<StageTrace>& trace, FreespaceVerdict StageTrace::*stage,
            const std::vector<std::int32_t>& indices, const std::vector<FreespaceVerdict>& verdicts) {
  for (std::size_t k = 0; k < indices.size(); ++k)
    trace[static_cast<std::size_t>(indices[k])].*stage = verdicts[k];
}

Duration distance(const PreparedScan& earlier, const PreparedScan& later) {
  return later.scan().start - earlier.scan().start;
}

bool was_outside(const StageTrace& t) { return t.past == FreespaceVerdict::outside; }
bool looks_dynamic(const StageTrace& t) { return t.candidate == CandidateVerdict::dynamic; }

class PublishedPipeline final : public DetectionPipeline {
 public:
  explicit PublishedPipeline(const DetectorParameters& parameters) : parameters_(parameters) {}

  void learn_own_vehicle(const LidarScan& /*scan*/, const Trajectory& /*trajectory*/) override {}

  void add(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory) override {
    buffer_.push_back(prepare(std::move(scan), trajectory));
  }

  [[nodiscard]] std::vector<std::shared_ptr<const RayImage>> rays_from(
      std::size_t /*number*/) const override {
    return {};
  }
  void add_rays_of_another_sensor(std::shared_ptr<const RayImage> /*rays*/) override {}

  ObjectProposals propose(std::size_t number) override {
    const auto gap = static_cast<std::size_t>(parameters_.scan_gap);
    while (first_number_ + gap < number) {  // the oldest reference scan from here on
      buffer_.pop_front();
      ++first_number_;
    }
    const std::size_t newest = first_number_ + buffer_.size() - 1;
    const PreparedScan& query = scan_number(number);
    const PreparedScan* reference = number == 0 ? nullptr : &scan_number(number < gap ? 0 : number - gap);
    const PreparedScan* other = number < newest ? &scan_number(newest) : nullptr;
    // At the start of a recording the later scan may be farther away than any earlier one, and shows more
    // motion.
    if (number < gap && other != nullptr &&
        (reference == nullptr || distance(query, *other) > distance(*reference, query))) {
      std::swap(reference, other);
    }
    ObjectProposals out = run_stages(query, reference, other);
    out.seconds = buffer_[number - first_number_].seconds + out.seconds;
    out.column_states = query.compensated.column_states;
    out.rays = std::make_shared<const RayImage>(query.compensated);
    return out;
  }

 private:
  struct BufferedScan {
    PreparedScan prepared;
    StageSeconds seconds;  // of its preparation
  };
  [[nodiscard]] const PreparedScan& scan_number(std::size_t number) const {
    return buffer_.at(number - first_number_).prepared;
  }
  [[nodiscard]] BufferedScan prepare(std::shared_ptr<const LidarScan> scan,
                                     const Trajectory& trajectory) const;
  [[nodiscard]] ObjectProposals run_stages(const PreparedScan& query, const PreparedScan* reference,
                                           const PreparedScan* other) const;

  DetectorParameters parameters_;
  std::deque<BufferedScan> buffer_;  // consecutive scans, oldest first
  std::size_t first_number_ = 0;     // of the oldest
};

// Step 1 gives the trajectory; here every return and ray gets its own pose.
PublishedPipeline::BufferedScan PublishedPipeline::prepare(std::shared_ptr<const LidarScan> scan,
                                                           const Trajectory& trajectory) const {
  StageSeconds seconds;
  CompensatedScan compensated =
      timed(seconds.compensation, [&] { return compensate(std::move(scan), trajectory); });
  NearestNeighbours neighbours =
      timed(seconds.neighbours, [&] { return NearestNeighbours(compensated.points_0); });
  auto normals =
      timed(seconds.normals, [&] { return estimate_normals(compensated, neighbours, parameters_.normals); });
  return {{std::move(compensated), std::move(neighbours), std::move(normals)}, seconds};
}

ObjectProposals PublishedPipeline::run_stages(const PreparedScan& query, const PreparedScan* reference,
                                              const PreparedScan* other) const {
  ObjectProposals out;
  out.scan = query.compensated.scan;
  out.trace.resize(out.scan->returns.size());

  // 2. Pointcloud comparison: points that the reference scan does not explain are candidates.
  if (reference != nullptr) {
    record(out.trace, &StageTrace::candidate, timed(out.seconds.comparison, [&] {
             return compare_pointclouds(query, *reference, parameters_.comparison);
           }));
  }
  // 3. Freespace check backward (Eq. 1, 2): candidates in the freespace of the reference scan are dynamic.
  if (reference != nullptr) {
    const auto candidates = points_where(out.trace, looks_dynamic);
    record(out.trace, &StageTrace::past, candidates, timed(out.seconds.backward, [&] {
             return check_freespace(query, candidates, reference->compensated,
                                    parameters_.freespace.backward_threshold_m, parameters_.freespace);
           }));
  }
  //    Forward, on the later scan: the candidates that were hidden from the reference scan.
  if (other != nullptr) {
    const auto hidden = points_where(out.trace, was_outside);
    record(out.trace, &StageTrace::future, hidden, timed(out.seconds.forward, [&] {
             return check_freespace(query, hidden, other->compensated,
                                    parameters_.freespace.forward_threshold_m, parameters_.freespace);
           }));
  }
  // 4. Box filter: dynamic points in single rows of the scan image are border effects.
  record(out.trace, &StageTrace::filtered, timed(out.seconds.filter, [&] {
           return filter_boxes(*out.scan, dynamic_points(out.trace, Stage::future), parameters_.box_filter);
         }));
  // 5. Clustering and region growth: whole objects.
  auto regions = timed(out.seconds.region_growth, [&] {
    return grow_regions(query, dynamic_points(out.trace, Stage::filtered), parameters_.region_growth);
  });
  record(out.trace, &StageTrace::growth, regions.verdict);
  out.object = std::move(regions.object);
  out.objects = regions.objects;
  return out;
}

}  // namespace

std::unique_ptr<DetectionPipeline> make_published_pipeline(const DetectorParameters& parameters) {
  return std::make_unique<PublishedPipeline>(parameters);
}

}  // namespace mapless
