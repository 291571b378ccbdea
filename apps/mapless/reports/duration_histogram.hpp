#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace mapless::app {

/// Quantiles of any number of durations in constant memory: counts durations in bins, each 1 % longer than
/// the one before. A quantile is within 0.5 % of the exact one between 1 us and 1000 s.
class DurationHistogram {
 public:
  void add(double seconds);
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Of the durations added [s]; nothing without any. `q` from 0 to 1.
  [[nodiscard]] std::optional<double> quantile(double q) const;

 private:
  static constexpr std::size_t kBins = 2085;  // ln(1000 s / 1 us) / ln(1.01), and one for shorter durations

  std::array<std::uint32_t, kBins> counts_ = {};
  std::size_t size_ = 0;
};

}  // namespace mapless::app
