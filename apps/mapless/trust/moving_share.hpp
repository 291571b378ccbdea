#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace mapless::app {

/// The share of points called moving, over a run. It tells scans whose poses, or whose place among the
/// others, are wrong: the static world then moves at once.
class MovingShare {
 public:
  /// Scan number `k` of the recording; in their order.
  void add(std::size_t k, std::size_t moving, std::size_t points);
  /// One line; empty where nothing is suspicious.
  [[nodiscard]] std::string trouble() const;

 private:
  std::size_t scans_ = 0, rises_ = 0, first_rise_ = 0;
  double rise_from_ = 0, rise_to_ = 0;  // of the first one
  std::size_t moving_ = 0, points_ = 0;
  std::array<double, 3> before_{};  // shares of the last scans
};

}  // namespace mapless::app
