#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <mapless/detection/ray_image.hpp>

namespace mapless {

/// A point about a scan's origin, as look_at_all wants it.
struct LookedAt {
  const Eigen::Vector3f& q;
  float column;  // about where the scan asked looks that way
};

/// Puts the points of(0), of(1), ... to a scan; `heard` is called with the number and the answer of each.
/// Consecutive firings look at consecutive columns of another scan too, so that the column one point was
/// found in tells where to look for the next.
template <class Of, class Heard>
void look_at_all(const FreespaceProbe& probe, std::size_t size, Of&& of, Heard&& heard) {
  constexpr std::size_t kAtOnce = FreespaceProbe::kAtOnce;
  constexpr std::size_t kEights = 16;  // asked together: what is kept of them should stay at hand
  std::array<FreespaceProbe::Points, kEights> points;
  std::array<FreespaceProbe::Answers, kEights> answers;
  float ahead = 0;  // of the point's own column
  for (std::size_t first = 0; first < size; first += kEights * kAtOnce) {
    const std::size_t count = std::min(kEights * kAtOnce, size - first);
    const std::size_t eights = (count + kAtOnce - 1) / kAtOnce;
    for (std::size_t k = 0; k < eights * kAtOnce; ++k) {  // the last one again where there are fewer
      const LookedAt asked = of(std::min(first + k, size - 1));
      FreespaceProbe::Points& eight = points[k / kAtOnce];
      const std::size_t l = k % kAtOnce;
      eight.x[l] = asked.q.x();
      eight.y[l] = asked.q.y();
      eight.z[l] = asked.q.z();
      if (l == 0) eight.near = asked.column;
      eight.near_last = asked.column;
    }
    points[0].near += ahead;
    probe.look(std::span(points).first(eights), std::span(answers).first(eights));
    ahead = points[eights - 1].column[kAtOnce - 1] - points[eights - 1].near_last;
    for (std::size_t k = 0; k < count; ++k) heard(first + k, answers[k / kAtOnce][k % kAtOnce]);
  }
}

}  // namespace mapless
