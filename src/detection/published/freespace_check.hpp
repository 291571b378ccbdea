#pragma once

#include <cstdint>
#include <vector>

#include "detection/published/prepared_scan.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>

namespace mapless::inline v1 {

/// Step 3 of the paper: whether each of the returns `queries` (indices into query.scan().returns) lies inside
/// the freespace observed by `reference`, on its border, or outside it. One verdict per element of `queries`.
/// `threshold_m`: the backward or the forward threshold [m]. `reference` may be earlier or later than
/// `query`.
///
/// This is apart from FreespaceProbe because it is the published method: the one nearest ray of Eq. 1 and 2
/// in double precision, compared along the point's normal. FreespaceProbe compares along the ray, needs no
/// normal and is faster; the two share the vocabulary, and freespace_agreement_test.cpp compares them.
[[nodiscard]] std::vector<FreespaceVerdict> check_freespace(const PreparedScan& query,
                                                            const std::vector<std::int32_t>& queries,
                                                            const CompensatedScan& reference,
                                                            double threshold_m,
                                                            const FreespaceParameters& parameters);

}  // namespace mapless
