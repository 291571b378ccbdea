#pragma once

#include <cstdint>
#include <vector>

#include <mapless/detection/detector.hpp>

namespace mapless {

/// One label per input record of the scan, in input order: kLabelDynamic with the object's number in the high
/// 16 bits, kLabelStatic, or 0 for a record without a return.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const Detection& detection);

/// One byte per input record: bit s is 1 where the point counted as dynamic after Stage s; 0 without a
/// return.
[[nodiscard]] std::vector<std::uint8_t> stage_masks_of(const Detection& detection);

}  // namespace mapless
