#include "detection/evidence/receding_ends.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "detection/freespace/packed_points.hpp"

namespace mapless::inline v1 {
namespace {

// An end is known to within the tolerance of range and the columns on either side of it; they are farther
// apart along a line that is seen at a slant.
constexpr float kEndColumns = 3, kLeastSlant = 0.2F;

// How far an end has receded is told in steps. A rounded corner does not look like two.
constexpr float kStep_m = 0.1F;
constexpr int kFewestSteps = 2, kMostSteps = 10, kNotSeen = -1;

// Cosine. Where a line comes steeply towards the sensor, rays above and below see its slanting end farther
// off or nearer, by any distance.
constexpr float kMostTowards = 0.5F;

}  // namespace

RecedingEnds::RecedingEnds(const LidarScan& scan, const LocalPoints& points,
                           const std::vector<AskedScan>& asked, const RayImage& own,
                           const VotingParameters& parameters)
    : scan_(scan),
      points_(points.points),
      own_(own, points.origin_0, parameters),
      column_rad_(2 * std::numbers::pi_v<float> / static_cast<float>(scan.columns)) {
  earlier_.reserve(asked.size());
  for (const AskedScan& a : asked) {
    if (a.gap > 0 && a.gap <= kLongestGap)
      earlier_.push_back({a.gap, FreespaceProbe(*a.image, points.origin_0, parameters)});
  }
  for (std::size_t nearer = 0; nearer < earlier_.size(); ++nearer) {
    for (std::size_t farther = nearer + 1; farther < earlier_.size(); ++farther) {
      if (earlier_[farther].gap == 2 * earlier_[nearer].gap) pairs_.push_back({nearer, farther});
    }
  }
}

std::vector<RecedingEnds::Line> RecedingEnds::among(std::span<const RowLine> lines) const {
  std::vector<Line> receding;
  if (pairs_.empty()) return receding;
  std::vector<End> ends;
  ends.reserve(2 * lines.size());
  for (const RowLine& line : lines) {
    for (const RowLine& to : {RowLine{line.last, line.first}, line}) {
      const Course course = course_of(to);
      if (may_be_free(to, course)) ends.push_back(end_of(to, course));
    }
  }
  // The farthest scan tells of most that they have not.
  keep(ends, earlier_.back().probe, FreespaceVerdict::border);
  keep(ends, own_, FreespaceVerdict::inside);
  for (const End& end : ends) {
    const Way way = way_of(end);
    if (way == Way::stays) continue;
    const auto [first, last] = std::minmax(end.line.first, end.line.last);
    receding.push_back({{first, last}, end.line.last, way == Way::slides});
  }
  return receding;
}

RecedingEnds::Course RecedingEnds::course_of(const RowLine& line) const {
  const Eigen::Vector3f &from = points_[static_cast<std::size_t>(line.first)],
                        &to = points_[static_cast<std::size_t>(line.last)];
  return {(to - from).normalized(), to.normalized()};
}

RecedingEnds::End RecedingEnds::end_of(const RowLine& line, const Course& course) const {
  const LidarReturn& r = scan_.returns[static_cast<std::size_t>(line.last)];
  const float across = std::max(course.outward.cross(course.ray).norm(), kLeastSlant);
  return {line, points_[static_cast<std::size_t>(line.last)], course.outward, static_cast<float>(r.column),
          own_.tolerance_m(r.laser, r.range_m) + kEndColumns * column_rad_ * r.range_m / across};
}

// At a glance: not where the next return is in front of what would go on along the line.
bool RecedingEnds::may_be_free(const RowLine& line, const Course& course) const {
  const std::int32_t next = line.last + (line.last > line.first ? 1 : -1);
  if (next < 0 || next >= static_cast<std::int32_t>(points_.size())) return true;
  const Eigen::Vector3f step =
      points_[static_cast<std::size_t>(next)] - points_[static_cast<std::size_t>(line.last)];
  const float out_along_ray = course.outward.dot(course.ray), step_along_ray = step.dot(course.ray);
  if (out_along_ray < -kMostTowards) return false;
  const float out_across = (course.outward - out_along_ray * course.ray).norm(),
              step_across = (step - step_along_ray * course.ray).norm();
  return step_along_ray * out_across > out_along_ray * step_across;
}

// Those beyond which the scan says so.
void RecedingEnds::keep(std::vector<End>& ends, const FreespaceProbe& scan, FreespaceVerdict verdict) {
  PackedPoints beyond;
  beyond.reserve(ends.size());
  for (const End& end : ends) beyond.add(end.beyond(end.clear_m), end.column);
  std::size_t kept = 0;
  beyond.look(scan, [&](std::size_t k, const FreespaceProbe::Answer& answer) {
    if (answer.verdict == verdict) ends[kept++] = ends[k];
  });
  ends.resize(kept);
}

RecedingEnds::Way RecedingEnds::way_of(const End& end) const {
  Steps steps;
  steps.fill(kNotSeen);
  for (const Earlier& e : earlier_) steps[static_cast<std::size_t>(e.gap)] = steps_receded(end, e);
  if (!goes_on(steps, end.clear_m)) return Way::stays;
  const auto gone = [&steps](const Earlier& e) { return steps[static_cast<std::size_t>(e.gap)]; };
  const bool goes = std::any_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
    const int nearer = gone(earlier_[pair.nearer]);
    return nearer >= kFewestSteps && gone(earlier_[pair.farther]) > nearer;
  });
  if (!goes) return Way::stays;
  const RowLine back{end.line.last, end.line.first};
  const End other = end_of(back, course_of(back));
  const bool held = std::any_of(earlier_.begin(), earlier_.end(), [&](const Earlier& e) {
    return stays(other, end.clear_m + kStep_m * static_cast<float>(gone(e)), e) ||
           steps_receded(other, e) > 0;
  });
  return held ? Way::shortens : Way::slides;
}

// Whether it looks like the way of one thing: no shorter since an earlier scan, to a step, and no more than
// twice as long since twice as long ago, unless it has slowed down.
bool RecedingEnds::goes_on(const Steps& steps, float clear_m) const {
  int last = 0;
  for (const int n : steps) {
    if (n != kNotSeen && n < last - 1) return false;
    last = n == kNotSeen ? last : n;
  }
  return std::none_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
    const int nearer = steps[static_cast<std::size_t>(earlier_[pair.nearer].gap)];
    const int farther = steps[static_cast<std::size_t>(earlier_[pair.farther].gap)];
    const auto at_least_m = [&](int n) { return clear_m + kStep_m * static_cast<float>(n); };
    return nearer != kNotSeen && at_least_m(farther) > 2 * at_least_m(nearer + 1);
  });
}

// kNotSeen where the scan could not see.
int RecedingEnds::steps_receded(const End& end, const Earlier& since) const {
  for (int steps = 0; steps < kMostSteps; ++steps) {
    const Eigen::Vector3f q = end.beyond(end.clear_m + static_cast<float>(steps) * kStep_m);
    float then = end.column, now = end.column;
    const FreespaceVerdict seen = since.probe.ask(q, then);
    if (steps == 0 && seen != FreespaceVerdict::border && seen != FreespaceVerdict::inside) return kNotSeen;
    if (seen != FreespaceVerdict::border || own_.ask(q, now) != FreespaceVerdict::inside) return steps;
  }
  return kMostSteps;
}

// Free beyond it now and then, and then a surface half as far before it as it should have come since.
bool RecedingEnds::stays(const End& end, float gone_m, const Earlier& since) const {
  if (gone_m < 2 * end.clear_m) return false;  // that cannot be told
  const Eigen::Vector3f q = end.beyond(end.clear_m);
  float now = end.column, then = end.column, within = end.column;
  return own_.ask(q, now) == FreespaceVerdict::inside &&
         since.probe.ask(q, then) == FreespaceVerdict::inside &&
         since.probe.ask(end.beyond(-gone_m / 2), within) == FreespaceVerdict::border;
}

}  // namespace mapless
