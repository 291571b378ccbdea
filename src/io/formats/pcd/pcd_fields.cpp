#include "io/formats/pcd/pcd_fields.hpp"

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "lidar/scan_builder/raw_points.hpp"

namespace mapless::inline v1 {
namespace {

const PcdField* first_of(const PcdCloud& cloud, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (const PcdField* field = cloud.find(name)) return field;
  }
  return nullptr;
}

NumberType type_of(const PcdField& field) {
  if (field.is_floating()) return field.size == 4 ? NumberType::float32 : NumberType::float64;
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1:
      return is_signed ? NumberType::int8 : NumberType::uint8;
    case 2:
      return is_signed ? NumberType::int16 : NumberType::uint16;
    case 4:
      return is_signed ? NumberType::int32 : NumberType::uint32;
    default:
      return is_signed ? NumberType::int64 : NumberType::uint64;
  }
}

NumberSpan numbers_of(const PcdCloud& cloud, const PcdField& field) {
  return {cloud.bytes.data() + field.offset, type_of(field), cloud.size(), cloud.stride};
}

}  // namespace

PointFields fields_of(const PcdCloud& cloud) {
  PointFields fields;
  fields.x = numbers_of(cloud, cloud.require("x"));
  fields.y = numbers_of(cloud, cloud.require("y"));
  fields.z = numbers_of(cloud, cloud.require("z"));
  if (const PcdField* ring = first_of(cloud, {"ring", "laser"})) fields.ring = numbers_of(cloud, *ring);
  if (const PcdField* time = first_of(cloud, {"t", "time", "timestamp"})) {
    fields.time = numbers_of(cloud, *time);
    fields.time_unit = time->is_floating() ? TimeUnit::seconds : TimeUnit::nanoseconds;
  }
  fields.time_reference = TimeReference::automatic;
  fields.rows = std::max<std::size_t>(cloud.height, 1);
  return fields;
}

std::optional<Time> first_time(const PcdCloud& cloud) {
  const RawPoints points = read_points(fields_of(cloud), cloud.file.string());
  const std::optional<std::int64_t> first_ns = points.first_time_ns;
  if (!first_ns || !points.times_are_absolute) return std::nullopt;
  return Time::from_nanoseconds(*first_ns);
}

}  // namespace mapless
