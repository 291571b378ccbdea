#include "io/files/las_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "io/files/little_endian.hpp"

namespace mapless::inline v1 {
namespace {

// Sizes of LAS 1.4-R15: the header, the header of a variable length record, a description of extra bytes, a
// point of format 6.
constexpr std::size_t kHeaderSize = 375, kRecordHeaderSize = 54, kExtraBytesSize = 192, kPointSize = 30;
constexpr std::uint8_t kPointFormat = 6;
constexpr std::uint16_t kWellKnownText = 1U << 4U;     // coordinate system as WKT, as point format 6 demands
constexpr std::uint8_t kUnsignedLong = 5, kFloat = 9;  // types of extra bytes: uint32, float32
constexpr std::uint8_t kOnlyReturn = 0x11;             // return 1 of 1
constexpr double kFinestStep_m = 1e-4;

void append_text(std::string& out, std::string_view text, std::size_t size) {
  out += text.substr(0, size);
  out.append(size - std::min(size, text.size()), '\0');
}

struct Steps {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), low = origin, high = origin;
  double step_m = kFinestStep_m;
};

Steps steps_of(const ExportCloud& cloud) {
  Steps out;
  if (cloud.points.empty()) return out;
  out.low = out.high = cloud.points.front();
  for (const Eigen::Vector3d& p : cloud.points) {
    out.low = out.low.cwiseMin(p);
    out.high = out.high.cwiseMax(p);
  }
  out.origin = cloud.points.front().array().round();
  const double reach =
      std::max((out.high - out.origin).cwiseAbs().maxCoeff(), (out.low - out.origin).cwiseAbs().maxCoeff());
  while (reach / out.step_m >= std::numeric_limits<std::int32_t>::max()) out.step_m *= 10;
  return out;
}

// The one variable length record: what the extra bytes of a point are.
std::string extra_bytes_record(const ExportCloud& cloud) {
  std::string out;
  append<std::uint16_t>(out, 0);
  append_text(out, "LASF_Spec", 16);
  append<std::uint16_t>(out, 4);
  append(out, static_cast<std::uint16_t>(kExtraBytesSize * cloud.columns.size()));
  append_text(out, "Extra bytes", 32);
  for (const CloudColumn& column : cloud.columns) {
    append<std::uint16_t>(out, 0);
    append(out, column.is_float ? kFloat : kUnsignedLong);
    append<std::uint8_t>(out, 0);
    append_text(out, column.name, 32);
    append_text(out, "", kExtraBytesSize - 36);
  }
  return out;
}

std::string header_of(const ExportCloud& cloud, const Steps& steps, std::size_t records_size) {
  std::string out = "LASF";
  append<std::uint16_t>(out, 0);
  append(out, kWellKnownText);
  append_text(out, "", 16);
  out += {'\1', '\4'};
  append_text(out, "mapless", 32);
  append_text(out, "mapless " MAPLESS_VERSION, 32);
  append<std::uint32_t>(out, 0);  // day and year of creation: not said, so that the bytes do not change
  append(out, static_cast<std::uint16_t>(kHeaderSize));
  append(out, static_cast<std::uint32_t>(kHeaderSize + records_size));
  append<std::uint32_t>(out, records_size > 0 ? 1 : 0);
  append(out, kPointFormat);
  append(out, static_cast<std::uint16_t>(kPointSize + 4 * cloud.columns.size()));
  append_text(out, "", 24);  // the counts of LAS 1.3
  for (int axis = 0; axis < 3; ++axis) append(out, steps.step_m);
  for (const double v : steps.origin) append(out, v);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    append(out, steps.high[axis]);
    append(out, steps.low[axis]);
  }
  append_text(out, "", 20);  // no waveforms, no extended records
  const std::uint64_t count = cloud.points.size();
  append(out, count);
  append(out, count);  // of first returns, and 14 times none
  append_text(out, "", 14 * sizeof(std::uint64_t));
  return out;
}

}  // namespace

std::string las_file(const ExportCloud& cloud) {
  const Steps steps = steps_of(cloud);
  const std::string records = cloud.columns.empty() ? "" : extra_bytes_record(cloud);
  std::string out = header_of(cloud, steps, records.size()) + records;
  out.reserve(out.size() + cloud.points.size() * (kPointSize + 4 * cloud.columns.size()));
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d whole = (cloud.points[i] - steps.origin) / steps.step_m;
    for (const double v : whole) append(out, static_cast<std::int32_t>(std::lround(v)));
    append<std::uint16_t>(out, 0);  // intensity
    append(out, kOnlyReturn);
    append_text(out, "", kPointSize - 15);  // flags, class, angle, source, time: not said
    for (const CloudColumn& column : cloud.columns) append(out, column.values[i]);
  }
  return out;
}

}  // namespace mapless
