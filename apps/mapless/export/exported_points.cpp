#include "export/exported_points.hpp"

#include <bit>
#include <cstdint>
#include <utility>

namespace mapless::app {
namespace {

// The class of a label as detect writes it, whatever moving or still class the label names; counts it.
std::uint32_t count_class(std::uint32_t label, ExportedPoints& counts) {
  switch (motion_of_label(label)) {
    case MotionTruth::still:
      ++counts.is_static;
      return kLabelStatic;
    case MotionTruth::moving:
      ++counts.moving;
      return kLabelDynamic;
    case MotionTruth::unknown:
      break;
  }
  ++counts.unknown;
  return kLabelUnknown;
}

bool is_wanted(std::uint32_t plain_label, ExportedClass wanted) {
  if (wanted == ExportedClass::all) return true;
  return plain_label == (wanted == ExportedClass::moving ? kLabelDynamic : kLabelStatic);
}

}  // namespace

ExportedPoints exported_points(const LabelledCloud& scan, ExportedClass wanted, bool in_sensor_frame) {
  ExportedPoints out;
  const SE3 T_v0 = scan.T_0v.inverse();
  CloudColumn labels{"label", {}}, objects{"object", {}}, records{"record", {}},
      probabilities{"probability", {}, true};
  for (std::size_t i = 0; i < scan.scan->returns.size(); ++i) {
    const std::uint32_t record = scan.scan->returns[i].input_index, label = scan.labels[record];
    const std::uint32_t plain = count_class(label, out);
    if (!is_wanted(plain, wanted)) continue;
    const Eigen::Vector3d point_0 = scan.points.origin_0 + scan.points.points[i].cast<double>();
    out.cloud.points.push_back(in_sensor_frame ? T_v0 * point_0 : point_0);
    if (wanted != ExportedClass::all) continue;
    labels.values.push_back(plain);
    objects.values.push_back(label >> 16U);
    records.values.push_back(record);
    if (scan.probability)
      probabilities.values.push_back(std::bit_cast<std::uint32_t>((*scan.probability)[record]));
  }
  if (wanted == ExportedClass::all)
    out.cloud.columns = {std::move(labels), std::move(objects), std::move(records)};
  if (wanted == ExportedClass::all && scan.probability) out.cloud.columns.push_back(std::move(probabilities));
  return out;
}

}  // namespace mapless::app
