#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <mapless/core/errors.hpp>
#include <mapless/detection/box_filter.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/detection/freespace_check.hpp>
#include <mapless/detection/pointcloud_comparison.hpp>
#include <mapless/detection/region_growth.hpp>

namespace mapless {
namespace {

template <class Step>
auto timed(double& seconds, Step&& step) {
  const auto start = std::chrono::steady_clock::now();
  auto result = step();
  seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

std::vector<char> dynamic_points(const std::vector<StageTrace>& trace, Stage stage) {
  std::vector<char> dynamic(trace.size());
  std::transform(trace.begin(), trace.end(), dynamic.begin(),
                 [stage](const StageTrace& t) { return static_cast<char>(dynamic_after(t, stage)); });
  return dynamic;
}

template <class Condition>
std::vector<std::int32_t> points_where(const std::vector<StageTrace>& trace, Condition&& condition) {
  std::vector<std::int32_t> indices;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    if (condition(trace[i])) indices.push_back(static_cast<std::int32_t>(i));
  }
  return indices;
}

template <class Verdict>
void record(std::vector<StageTrace>& trace, Verdict StageTrace::*stage,
            const std::vector<Verdict>& verdicts) {
  for (std::size_t i = 0; i < trace.size(); ++i) trace[i].*stage = verdicts[i];
}

void record(std::vector<StageTrace>& trace, FreespaceVerdict StageTrace::*stage,
            const std::vector<std::int32_t>& indices, const std::vector<FreespaceVerdict>& verdicts) {
  for (std::size_t k = 0; k < indices.size(); ++k)
    trace[static_cast<std::size_t>(indices[k])].*stage = verdicts[k];
}

Duration distance(const PreparedScan& earlier, const PreparedScan& later) {
  return later.scan().start - earlier.scan().start;
}

bool was_outside(const StageTrace& t) { return t.backward == FreespaceVerdict::outside; }
bool looks_dynamic(const StageTrace& t) { return t.comparison == ComparisonVerdict::dynamic; }

}  // namespace

struct Detector::BufferedScan {
  PreparedScan prepared;
  StageSeconds seconds;  // of its preparation
};

Detector::Detector(const DetectorParameters& parameters) : parameters_(parameters) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::optional<Detection> Detector::process(std::shared_ptr<const LidarScan> scan,
                                           const Trajectory& trajectory) {
  if (!buffer_.empty() && scan->start <= buffer_.back()->prepared.scan().start) {
    throw InputError({"scan " + std::to_string(next_number_), "start",
                      std::to_string(scan->start.nanoseconds()) + " ns", "not after the scan before it",
                      "give scans by increasing time"});
  }
  buffer_.push_back(prepare(std::move(scan), trajectory));
  ++next_number_;
  const auto gap = static_cast<std::size_t>(parameters_.forward_gap);
  if (next_number_ <= next_detection_ + gap) return std::nullopt;
  return next(parameters_.forward_gap == 0 ? nullptr : &scan_number(next_detection_ + gap));
}

std::optional<Detection> Detector::flush() {
  if (next_detection_ == next_number_) return std::nullopt;
  const std::size_t newest = next_number_ - 1;
  return next(newest > next_detection_ ? &scan_number(newest) : nullptr);
}

// Step 1 gives the poses; here every return and ray gets its own.
std::shared_ptr<const Detector::BufferedScan> Detector::prepare(std::shared_ptr<const LidarScan> scan,
                                                                const Trajectory& trajectory) const {
  StageSeconds seconds;
  CompensatedScan compensated =
      timed(seconds.compensation, [&] { return compensate(std::move(scan), trajectory); });
  NearestNeighbours neighbours =
      timed(seconds.neighbours, [&] { return NearestNeighbours(compensated.points_0); });
  auto normals =
      timed(seconds.normals, [&] { return estimate_normals(compensated, neighbours, parameters_.normals); });
  return std::make_shared<const BufferedScan>(
      BufferedScan{{std::move(compensated), std::move(neighbours), std::move(normals)}, seconds});
}

std::optional<Detection> Detector::next(const PreparedScan* later) {
  const std::size_t number = next_detection_++;
  const auto gap = static_cast<std::size_t>(parameters_.scan_gap);
  const PreparedScan& query = scan_number(number);
  const PreparedScan* reference = number == 0 ? nullptr : &scan_number(number < gap ? 0 : number - gap);
  const PreparedScan* other = later;
  // At the start of a recording the later scan may be farther off than any earlier one, and tells more.
  if (number < gap && other != nullptr &&
      (reference == nullptr || distance(query, *other) > distance(*reference, query))) {
    std::swap(reference, other);
  }
  Detection detection = detect(query, reference, other);
  detection.sequence_number = number;
  detection.seconds = buffered(number).seconds + detection.seconds;
  // The oldest scan the next detection can ask for.
  const std::size_t oldest_needed = next_detection_ < gap ? 0 : next_detection_ - gap;
  while (first_number() < oldest_needed && buffer_.size() > 1) buffer_.pop_front();
  return detection;
}

Detection Detector::detect(const PreparedScan& query, const PreparedScan* reference,
                           const PreparedScan* other) const {
  Detection out;
  out.scan = query.compensated.scan;
  out.trace.resize(out.scan->returns.size());

  // 2. Pointcloud comparison: what the reference scan does not explain.
  if (reference != nullptr) {
    record(out.trace, &StageTrace::comparison, timed(out.seconds.comparison, [&] {
             return compare_pointclouds(query, *reference, parameters_.comparison);
           }));
  }
  // 3. Freespace check backward (Eq. 1, 2): of that, what stands where the reference scan's rays went
  // through.
  if (reference != nullptr) {
    const auto candidates = points_where(out.trace, looks_dynamic);
    record(out.trace, &StageTrace::backward, candidates, timed(out.seconds.backward, [&] {
             return check_freespace(query, candidates, reference->compensated,
                                    parameters_.freespace.backward_threshold_m, parameters_.freespace);
           }));
  }
  //    and forward, on the later scan: what was hidden then, and has left by now.
  if (other != nullptr) {
    const auto hidden = points_where(out.trace, was_outside);
    record(out.trace, &StageTrace::forward, hidden, timed(out.seconds.forward, [&] {
             return check_freespace(query, hidden, other->compensated,
                                    parameters_.freespace.forward_threshold_m, parameters_.freespace);
           }));
  }
  // 4. Box filter: single rows of the scan image are border effects.
  record(out.trace, &StageTrace::box, timed(out.seconds.box_filter, [&] {
           return filter_boxes(*out.scan, dynamic_points(out.trace, Stage::forward), parameters_.box_filter);
         }));
  // 5. Clustering and region growth: whole objects.
  auto regions = timed(out.seconds.region_growth, [&] {
    return grow_regions(query, dynamic_points(out.trace, Stage::box_filter), parameters_.region_growth);
  });
  record(out.trace, &StageTrace::growth, regions.verdict);
  out.object = std::move(regions.object);
  out.objects = regions.objects;
  return out;
}

const Detector::BufferedScan& Detector::buffered(std::size_t number) const {
  return *buffer_.at(number - first_number());
}

const PreparedScan& Detector::scan_number(std::size_t number) const { return buffered(number).prepared; }

}  // namespace mapless
