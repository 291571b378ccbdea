#pragma once

#include <cstdint>
#include <vector>

#include "detection/published/prepared_scan.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>

namespace mapless::inline v1 {

/// Step 3: whether each of the returns `queries` (indices into query.scan().returns) stands inside the
/// freespace that the rays of `reference` measured, on its border, or outside it. One verdict per element of
/// `queries`. `threshold_m` is the backward or the forward threshold; `reference` may be earlier or later
/// than `query`.
[[nodiscard]] std::vector<FreespaceVerdict> check_freespace(const PreparedScan& query,
                                                            const std::vector<std::int32_t>& queries,
                                                            const CompensatedScan& reference,
                                                            double threshold_m,
                                                            const FreespaceParameters& parameters);

}  // namespace mapless
