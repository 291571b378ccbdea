#pragma once

#include <vector>

#include "detection/published/prepared_scan.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>

namespace mapless::inline v1 {

/// Step 2: compares every point q of `query` with its nearest point p of `reference`, both in frame 0: |n .
/// (p - q)| where q has a normal n, else ||p - q||; above the error threshold q is dynamic. One verdict per
/// return of `query`. An empty reference compares nothing.
[[nodiscard]] std::vector<CandidateVerdict> compare_pointclouds(const PreparedScan& query,
                                                                const PreparedScan& reference,
                                                                const ComparisonParameters& parameters);

}  // namespace mapless
