#pragma once

#include <optional>
#include <vector>

namespace mapless::inline v1 {

/// The value below which a fraction `q` in [0, 1] of `values` lies, linear between the two nearest ranks (the
/// median of an even count is the mean of the middle two). Absent for no values.
[[nodiscard]] std::optional<double> quantile(std::vector<double> values, double q);

}  // namespace mapless
