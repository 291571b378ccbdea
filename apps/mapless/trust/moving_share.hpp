#pragma once

#include <array>
#include <cstddef>
#include <string>

#include <mapless/detection/detection.hpp>

namespace mapless::app {

/// The share of points called moving, over a run. It tells scans whose poses, or whose place among the
/// others, are wrong: the static world then moves at once.
class MovingShare {
 public:
  /// Numbers of points by the azimuth at which they were measured, the turn in equal sectors.
  static constexpr std::size_t kSectors = 16;
  using Sectors = std::array<std::size_t, kSectors>;

  /// Scan number `k` of the recording; in their order.
  void add(std::size_t k, const Sectors& moving, const Sectors& points);
  /// The same, of a labelled scan.
  void add(std::size_t k, const Detection& detection);
  /// One line; empty where nothing is suspicious.
  [[nodiscard]] std::string trouble() const;

 private:
  std::size_t scans_ = 0, rises_ = 0, first_rise_ = 0;
  double rise_from_ = 0, rise_to_ = 0;  // of the first one
  std::size_t moving_ = 0, points_ = 0;
  struct Shares {
    double all = 0;
    double least_half = 0;  // the least of any half turn
  };
  static Shares shares_of(const Sectors& moving, const Sectors& points);
  std::array<Shares, 3> before_{};  // of the last scans
};

}  // namespace mapless::app
