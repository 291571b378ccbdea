#include "reports/duration_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace mapless::app {
namespace {

constexpr double kShortest_s = 1e-6;
const double kBinRatio_log = std::log(1.01);

}  // namespace

void DurationHistogram::add(double seconds) {
  const double bin = seconds > kShortest_s ? 1 + std::log(seconds / kShortest_s) / kBinRatio_log : 0;
  ++counts_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++size_;
}

std::optional<double> DurationHistogram::quantile(double q) const {
  if (size_ == 0) return std::nullopt;
  const auto rank = static_cast<std::size_t>(std::lround(q * static_cast<double>(size_ - 1)));
  std::size_t bin = 0;
  for (std::size_t below = counts_[0]; below <= rank; below += counts_[bin]) ++bin;
  // The middle of the bin; durations in the first are 0 as far as anyone is concerned.
  return bin == 0 ? 0 : kShortest_s * std::exp((static_cast<double>(bin) - 0.5) * kBinRatio_log);
}

}  // namespace mapless::app
