#include "view/scan_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <zlib.h>

#include "view/planes.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

constexpr unsigned kNoTruth = 3, kUnknownProbability = 255;

unsigned class_bits(std::uint32_t label) {
  switch (motion_of_label(label)) {
    case MotionTruth::still:
      return 1;
    case MotionTruth::moving:
      return 2;
    case MotionTruth::unknown:
      return 0;
  }
  return 0;
}

double step_of(const LocalPoints& points) {
  float farthest = 0;
  // Turning the axes keeps the norm, so every coordinate is within it.
  for (const Eigen::Vector3f& p : points.points) farthest = std::max(farthest, p.norm());
  return std::max(kCoordinateStep_m, 1.001 * farthest / std::numeric_limits<std::int16_t>::max());
}

void append_coordinates(std::string& out, const LocalPoints& points, const Eigen::Matrix3d& R_page_world,
                        double step_m) {
  const Eigen::Matrix3f R = (R_page_world / step_m).cast<float>();
  std::array<std::vector<std::uint16_t>, 3> axes;
  for (auto& axis : axes) axis.reserve(points.points.size());
  for (const Eigen::Vector3f& p : points.points) {
    const Eigen::Vector3f steps = R * p;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto whole = static_cast<std::int16_t>(std::lround(steps[static_cast<Eigen::Index>(a)]));
      axes.at(a).push_back(static_cast<std::uint16_t>(whole));
    }
  }
  for (const auto& axis : axes) append_planes(out, axis);
}

void append_labels(std::string& out, ScanBlock& block, const LabelledCloud& cloud) {
  const auto& returns = cloud.scan->returns;
  std::vector<std::uint16_t> objects;
  objects.reserve(returns.size());
  for (const LidarReturn& r : returns) {
    const std::uint32_t label = cloud.labels[r.input_index];
    const unsigned found = class_bits(label);
    const unsigned truth = cloud.truth ? class_bits((*cloud.truth)[r.input_index]) : kNoTruth;
    block.dynamic += found == 2 ? 1U : 0U;
    block.hits += found == 2 && truth == 2 ? 1U : 0U;
    block.false_positives += found == 2 && truth == 1 ? 1U : 0U;
    block.missed += found != 2 && truth == 2 ? 1U : 0U;
    out.push_back(static_cast<char>(found | truth << 2U));
    objects.push_back(static_cast<std::uint16_t>(label >> 16U));
  }
  append_planes(out, objects);
}

char probability_byte(float probability) {
  if (std::isnan(probability)) return static_cast<char>(kUnknownProbability);
  return static_cast<char>(std::lround(254 * std::clamp(probability, 0.0F, 1.0F)));
}

}  // namespace

ScanBlock encode_scan(const LabelledCloud& cloud, const Eigen::Matrix3d& R_page_world,
                      const OptionalPlanes& planes) {
  const LidarScan& scan = *cloud.scan;
  ScanBlock block;
  block.points = scan.returns.size();
  block.step_m = step_of(cloud.points);
  std::vector<std::uint32_t> of_laser(static_cast<std::size_t>(scan.rows())), records;
  std::vector<std::uint16_t> columns;
  for (const LidarReturn& r : scan.returns) {
    ++of_laser[static_cast<std::size_t>(r.laser)];
    columns.push_back(static_cast<std::uint16_t>(r.column));
    records.push_back(r.input_index);
  }
  append_planes(block.bytes, of_laser);
  append_coordinates(block.bytes, cloud.points, R_page_world, block.step_m);
  append_planes(block.bytes, columns);
  append_planes(block.bytes, records);
  append_labels(block.bytes, block, cloud);
  if (planes.stages) {
    for (const LidarReturn& r : scan.returns)
      block.bytes.push_back(cloud.stages ? static_cast<char>((*cloud.stages)[r.input_index]) : '\0');
  }
  if (planes.probability) {
    for (const LidarReturn& r : scan.returns)
      block.bytes.push_back(cloud.probability ? probability_byte((*cloud.probability)[r.input_index])
                                              : static_cast<char>(kUnknownProbability));
  }
  return block;
}

std::string compress_zlib(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  // Level 6: level 9 takes four times as long for 1 % fewer bytes.
  const int outcome =
      compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), 6);
  if (outcome != Z_OK) throw Error({"", "", "", "not enough memory to compress a scan", "close programs"});
  out.resize(size);
  return out;
}

}  // namespace mapless::app
