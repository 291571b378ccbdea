#include <mapless/evaluation/evaluator.hpp>

namespace mapless::inline v1 {

std::optional<double> Found::share() const {
  if (of == 0) return std::nullopt;
  return static_cast<double>(found) / static_cast<double>(of);
}

std::optional<double> FalseObjects::per_scan() const {
  if (scans == 0 || (objects == 0 && unnumbered_points > 0)) return std::nullopt;
  return static_cast<double>(false_ones) / static_cast<double>(scans);
}

}  // namespace mapless
