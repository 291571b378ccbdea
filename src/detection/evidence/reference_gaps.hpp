#pragma once

#include <cstddef>
#include <vector>

#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// How far the reference scans lie before the query scan, increasing [scans]: `first_gap` times 1, 2, 3, 4,
/// 6, 8, 12, 16, ..., two to an octave, so that as many reference scans are of a moment ago as of seconds
/// ago.
inline std::vector<std::size_t> reference_gaps(const VotingParameters& parameters) {
  std::vector<std::size_t> gaps;
  for (int k = 0; k < parameters.references; ++k) {
    const int steps = k == 0 ? 1 : (k % 2 == 1 ? 2 : 3) << ((k - 1) / 2);
    gaps.push_back(static_cast<std::size_t>(parameters.first_gap * steps));
  }
  return gaps;
}

}  // namespace mapless
