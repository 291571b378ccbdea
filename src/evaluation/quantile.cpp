#include <algorithm>
#include <cmath>

#include "core/argument_checks.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::inline v1 {

std::optional<double> quantile(std::vector<double> values, double q) {
  require_between("quantile", "q", q, 0, 1);
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const double rank = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], rank - static_cast<double>(below));
}

}  // namespace mapless
