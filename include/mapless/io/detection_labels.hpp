#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <mapless/detection/detection.hpp>
#include <mapless/detection/tracked_object.hpp>
#include <mapless/io/object_table.hpp>

namespace mapless::inline v1 {

/// One label per input record of the scan, in input order: kLabelDynamic with the object's number in the high
/// 16 bits, kLabelStatic, or 0 for a record without a return.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const Detection& detection);
/// The same with label_number(id) of the objects, all those of the scan, for their number.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const Detection& detection,
                                                   const std::vector<TrackedObject>& objects);

/// The objects of scan `scan` as rows of objects.csv.
[[nodiscard]] std::vector<ObjectRow> object_rows(std::size_t scan, const std::vector<TrackedObject>& objects);

/// One byte per input record: bit s is 1 where the point counted as dynamic after Stage s; 0 without a
/// return.
[[nodiscard]] std::vector<std::uint8_t> stage_masks_of(const Detection& detection);

}  // namespace mapless
