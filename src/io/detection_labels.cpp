#include <mapless/io/detection_labels.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace {

std::uint8_t stage_mask(const StageTrace& trace) {
  unsigned mask = 0;
  for (unsigned s = 0; s < kStageCount; ++s) {
    if (dynamic_after(trace, static_cast<Stage>(s))) mask |= 1u << s;
  }
  return static_cast<std::uint8_t>(mask);
}

}  // namespace

std::vector<std::uint32_t> labels_of(const Detection& detection) {
  const LidarScan& scan = *detection.scan;
  std::vector<std::uint32_t> labels(scan.input_size, kLabelUnknown);
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const std::uint32_t object = detection.object[i];
    labels[scan.returns[i].input_index] = object != 0 ? kLabelDynamic | object << 16 : kLabelStatic;
  }
  return labels;
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
