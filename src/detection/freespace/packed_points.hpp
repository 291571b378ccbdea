#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/freespace/freespace_probe.hpp"

namespace mapless::inline v1 {

/// Points about a scan's origin in the layout of FreespaceProbe::observe, eight at a time, kept so from one
/// reference scan to the next.
class PackedPoints {
 public:
  [[nodiscard]] std::size_t size() const { return columns_.size(); }
  void clear() { columns_.clear(); }
  void reserve(std::size_t size) {
    columns_.reserve(size);
    eights_.reserve((size + kAtOnce - 1) / kAtOnce);
  }
  /// `column`: guess of the column in which the reference scans observe q.
  void add(const Eigen::Vector3f& q, float column, SurfaceSlopes slopes = {}) {
    const std::size_t k = size();
    columns_.push_back(column);
    if (k / kAtOnce == eights_.size()) eights_.emplace_back();
    Eight& eight = eights_[k / kAtOnce];
    eight.x[k % kAtOnce] = q.x();
    eight.y[k % kAtOnce] = q.y();
    eight.z[k % kAtOnce] = q.z();
    eight.slope_up[k % kAtOnce] = slopes.up;
    eight.slope_left[k % kAtOnce] = slopes.left;
  }
  /// Point `to` becomes what point `from` is.
  void move(std::size_t from, std::size_t to) {
    columns_[to] = columns_[from];
    copy(from, to);
  }
  /// Leaves the first `size`.
  void shrink(std::size_t size) { columns_.resize(size); }

  /// Observes all points through `probe`; calls `take(number, answer)` for each. Points of consecutive
  /// firings lie in consecutive columns of another scan too, so the column of one point is the guess for the
  /// next.
  template <class Take>
  void observe(const FreespaceProbe& probe, Take&& take) {
    const std::size_t eights = (size() + kAtOnce - 1) / kAtOnce;
    for (std::size_t k = size(); k < eights * kAtOnce; ++k) copy(size() - 1, k);  // fill the last eight
    float ahead = 0;                                                              // of the point's own column
    for (std::size_t first = 0; first < eights; first += kEights) {
      const auto some = std::span(eights_).subspan(first, std::min(kEights, eights - first));
      for (std::size_t k = 0; k < some.size(); ++k) {
        some[k].near = columns_[(first + k) * kAtOnce];
        some[k].near_last = columns_[std::min((first + k + 1) * kAtOnce, size()) - 1];
      }
      some.front().near += ahead;
      probe.observe(some, std::span(answers_).first(some.size()));
      ahead = some.back().column.back() - some.back().near_last;
      const std::size_t end = std::min((first + kEights) * kAtOnce, size());
      for (std::size_t k = first * kAtOnce; k < end; ++k) take(k, answers_[k / kAtOnce - first][k % kAtOnce]);
    }
  }

 private:
  static constexpr std::size_t kAtOnce = FreespaceProbe::kAtOnce;
  static constexpr std::size_t kEights = 16;  // observed together: their answers stay in the cache
  using Eight = FreespaceProbe::Points;

  void copy(std::size_t from, std::size_t to) {
    const Eight& source = eights_[from / kAtOnce];
    Eight& target = eights_[to / kAtOnce];
    target.x[to % kAtOnce] = source.x[from % kAtOnce];
    target.y[to % kAtOnce] = source.y[from % kAtOnce];
    target.z[to % kAtOnce] = source.z[from % kAtOnce];
    target.slope_up[to % kAtOnce] = source.slope_up[from % kAtOnce];
    target.slope_left[to % kAtOnce] = source.slope_left[from % kAtOnce];
  }

  std::vector<Eight> eights_;
  std::vector<float> columns_;  // of each point
  std::array<FreespaceProbe::Answers, kEights> answers_;
};

}  // namespace mapless
