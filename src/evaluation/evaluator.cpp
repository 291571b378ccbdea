#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

#include "evaluation/scan_checks.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

// Range limits of EvaluationReport::within_range: 5, 10 ... 120 m, to the maximum range of an HDL-64E.
constexpr double kLimitStep_m = 5;
constexpr int kLimits = 24;
// Edges of the bands, in steps of about a factor of two.
constexpr auto kRangeEdges_m = {0.0, 10.0, 20.0, 30.0, 50.0, 80.0, 120.0};
constexpr auto kSpeedEdges_mps = {0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0};
constexpr auto kVisiblePointEdges = {0.0, 4.0, 9.0, 19.0, 49.0, 199.0};

template <class What>
std::vector<Band<What>> bands(std::initializer_list<double> edges) {
  std::vector<Band<What>> out;
  for (const double edge : edges) {
    if (!out.empty()) out.back().up_to = edge;
    out.push_back({edge, std::numeric_limits<double>::infinity(), {}});
  }
  return out;
}

// The band of a value >= 0.
template <class What>
What& band_of(std::vector<Band<What>>& bands, double value) {
  const auto band =
      std::find_if(bands.begin(), bands.end() - 1, [value](const Band<What>& b) { return value <= b.up_to; });
  return band->counts;
}

void add_to(Found& found, std::int64_t hits, std::int64_t of) {
  found.found += hits;
  found.of += of;
}

void add_point(Counts& counts, bool truth_dynamic, bool called_dynamic) {
  if (truth_dynamic) {
    ++(called_dynamic ? counts.tp : counts.fn);
  } else {
    ++(called_dynamic ? counts.fp : counts.tn);
  }
}

// Index of the smallest range limit that includes the point; kLimits for points beyond the last.
std::size_t step_of(double range_m) {
  const double step = std::ceil(range_m / kLimitStep_m) - 1;
  return static_cast<std::size_t>(std::clamp(step, 0.0, static_cast<double>(kLimits)));
}

// Counts of the objects of the result, by their number in this scan.
class ResultObjects {
 public:
  void add(std::uint32_t label, bool truth_dynamic) {
    const std::uint32_t number = label >> 16;
    if (number == 0) {
      ++unnumbered_;
    } else {
      ++(truth_dynamic ? objects_[number].dynamic : objects_[number].still);
    }
  }
  void add_to(FalseObjects& sum) const {
    ++sum.scans;
    sum.unnumbered_points += unnumbered_;
    for (const auto& [number, object] : objects_) {
      ++sum.objects;
      if (object.still > object.dynamic) ++sum.false_ones;
    }
  }

 private:
  struct Object {
    std::int64_t dynamic = 0, still = 0;
  };
  std::map<std::uint32_t, Object> objects_;
  std::int64_t unnumbered_ = 0;
};

}  // namespace

// All points of one true object in one scan.
struct Evaluator::ObjectInScan {
  Counts points;
  double range_sum_m = 0;
  std::int64_t with_range = 0;

  [[nodiscard]] std::int64_t dynamic() const { return points.tp + points.fn; }
  [[nodiscard]] bool found() const { return 2 * points.tp >= dynamic(); }
  [[nodiscard]] bool evident(double speed_mps) const {
    return speed_mps > kEvidentSpeed_mps && points.points() >= kEvidentPoints && with_range > 0 &&
           range_sum_m <= kEvidentRange_m * static_cast<double>(with_range);
  }
};

std::vector<float> ranges_of(const LidarScan& scan) {
  std::vector<float> ranges(scan.input_size, std::numeric_limits<float>::quiet_NaN());
  for (const LidarReturn& r : scan.returns) ranges[r.input_index] = r.range_m;
  return ranges;
}

Evaluator::Evaluator(ObjectTruth objects, std::optional<double> max_range_m)
    : truth_(std::move(objects)), max_range_m_(max_range_m) {
  if (max_range_m_) require_range_limit("Evaluator", *max_range_m_);
  report_.by_range = bands<Counts>(kRangeEdges_m);
  for (int i = 1; i <= kLimits; ++i) report_.within_range.push_back({i * kLimitStep_m, {}});
  report_.by_visible_points = bands<Found>(kVisiblePointEdges);
  if (!truth_.has_states) return;
  report_.by_speed = bands<Found>(kSpeedEdges_mps);
  report_.evident_movers.emplace();
}

void Evaluator::add(const ScanLabels& scan) {
  require_equal_lengths(scan.number, scan.truth.size(), scan.result.size(), scan.ranges_m.size());
  Counts total;
  std::vector<Counts> by_step(kLimits + 1);
  std::map<std::uint32_t, ObjectInScan> objects;
  ResultObjects result_objects;
  std::uint32_t id = 0;
  ObjectInScan* object = nullptr;
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    const MotionTruth truth = motion_of_label(scan.truth[i]);
    if (truth == MotionTruth::unknown) continue;
    const double range = scan.ranges_m[i];
    if (max_range_m_ && !(range <= *max_range_m_)) continue;
    const bool dynamic = truth == MotionTruth::moving;
    const bool called = motion_of_label(scan.result[i]) == MotionTruth::moving;
    add_point(total, dynamic, called);
    // Consecutive points mostly belong to one object.
    if (const std::uint32_t next = scan.truth[i] >> 16; object == nullptr || next != id) {
      id = next;
      object = &objects[id];
    }
    add_point(object->points, dynamic, called);
    if (called) result_objects.add(scan.result[i], dynamic);
    if (std::isnan(range)) continue;
    object->range_sum_m += range;
    ++object->with_range;
    add_point(by_step[step_of(range)], dynamic, called);
    add_point(band_of(report_.by_range, range), dynamic, called);
  }
  report_.points.add(total);
  add_ranges(by_step);
  for (const auto& [number, points] : objects) add_object(scan.number, number, points);
  result_objects.add_to(report_.false_objects);
}

void Evaluator::add_ranges(const std::vector<Counts>& by_step) {
  Counts within;
  for (std::size_t i = 0; i < report_.within_range.size(); ++i) {
    within += by_step[i];
    report_.within_range[i].points.add(within);
  }
}

void Evaluator::add_object(std::size_t scan, std::uint32_t id, const ObjectInScan& object) {
  const auto description = truth_.descriptions.find(id);
  const bool described = id != 0 && description != truth_.descriptions.end();
  const std::string name(described ? description->second.object_class : id == 0 ? kNoObject : kUnlisted);
  ClassTally& of_class = classes_[name];
  of_class.points += object.points;
  kinds_[{name, described ? description->second.kind : ""}] += object.points;
  if (id == 0 || object.dynamic() == 0) return;

  const std::int64_t hits = object.points.tp;
  const std::int64_t found = object.found() ? 1 : 0;
  add_to(report_.objects, found, 1);
  add_to(of_class.objects, found, 1);
  const auto visible = static_cast<double>(object.points.points());
  add_to(band_of(report_.by_visible_points, visible), hits, object.dynamic());
  if (!truth_.has_states) return;
  const auto state = truth_.states.find({scan, id});
  if (state == truth_.states.end()) return;
  const double speed = state->second.speed_mps;
  add_to(band_of(report_.by_speed, speed), hits, object.dynamic());
  if (!object.evident(speed)) return;
  add_to(*report_.evident_movers, found, 1);
  add_to(of_class.evident_movers, found, 1);
}

EvaluationReport Evaluator::report() const {
  EvaluationReport out = report_;
  if (!truth_.has_descriptions) return out;
  for (const auto& [name, tally] : classes_) {
    out.by_class.push_back({name, tally.points, tally.objects, std::nullopt});
    if (truth_.has_states) out.by_class.back().evident_movers = tally.evident_movers;
  }
  for (const auto& [key, points] : kinds_) out.by_kind.push_back({key.first, key.second, points});
  return out;
}

}  // namespace mapless
