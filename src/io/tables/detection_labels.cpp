#include <algorithm>

#include <mapless/detection/detection.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::inline v1 {
namespace {

std::uint8_t stage_mask(const StageTrace& trace) {
  unsigned mask = 0;
  for (unsigned s = 0; s < kStageCount; ++s) {
    if (dynamic_after(trace, static_cast<Stage>(s))) mask |= 1u << s;
  }
  return static_cast<std::uint8_t>(mask);
}

// `number_of` maps the object numbers of the detection to those in the labels.
template <class NumberOf>
std::vector<std::uint32_t> labels_with(const Detection& detection, const NumberOf& number_of) {
  const LidarScan& scan = *detection.scan;
  std::vector<std::uint32_t> labels(scan.input_size, kLabelUnknown);
  if (!detection.motion_known) return labels;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const std::uint16_t object = detection.object[i];
    labels[scan.returns[i].input_index] =
        object != 0 ? kLabelDynamic | static_cast<std::uint32_t>(number_of(object)) << 16 : kLabelStatic;
  }
  return labels;
}

}  // namespace

std::vector<std::uint32_t> labels_of(const Detection& detection) {
  return labels_with(detection, [](std::uint16_t object) { return object; });
}

std::vector<std::uint32_t> labels_of(const Detection& detection, const std::vector<TrackedObject>& objects) {
  std::vector<std::uint16_t> numbers(std::size_t{1} << 16, 0);
  for (const TrackedObject& object : objects) numbers[object.number] = label_number(object.id);
  return labels_with(detection, [&numbers](std::uint16_t object) { return numbers[object]; });
}

std::vector<ObjectRow> object_rows(std::size_t scan, const std::vector<TrackedObject>& objects) {
  std::vector<ObjectRow> rows;
  for (const TrackedObject& o : objects) {
    rows.push_back(
        {scan, o.time, o.id, o.points, o.centre_0, o.extent_0, o.velocity_0, o.velocity_std_0(), o.age});
  }
  std::sort(rows.begin(), rows.end(), [](const ObjectRow& a, const ObjectRow& b) { return a.id < b.id; });
  return rows;
}

std::vector<std::uint8_t> stage_masks_of(const Detection& detection) {
  const LidarScan& scan = *detection.scan;
  std::vector<std::uint8_t> masks(scan.input_size, 0);
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    masks[scan.returns[i].input_index] = stage_mask(detection.trace[i]);
  }
  return masks;
}

}  // namespace mapless
