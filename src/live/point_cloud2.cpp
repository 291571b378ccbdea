#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/live/point_cloud2.hpp>

namespace mapless::inline v1 {
namespace {

struct FieldType {
  NumberType type;
  std::uint32_t bytes;
};

// sensor_msgs/PointField: INT8 = 1 ... FLOAT64 = 8.
std::optional<FieldType> type_of(std::uint8_t datatype) {
  static constexpr std::array<FieldType, 8> kTypes = {{{NumberType::int8, 1},
                                                       {NumberType::uint8, 1},
                                                       {NumberType::int16, 2},
                                                       {NumberType::uint16, 2},
                                                       {NumberType::int32, 4},
                                                       {NumberType::uint32, 4},
                                                       {NumberType::float32, 4},
                                                       {NumberType::float64, 8}}};
  if (datatype < 1 || datatype > kTypes.size()) return std::nullopt;
  return kTypes[datatype - 1];
}

void require_layout(const PointCloud2View& cloud, const std::string& source) {
  const std::uint64_t used = std::uint64_t{cloud.width} * cloud.point_step;
  if (cloud.row_step < used && cloud.height > 0) {
    throw InputError(
        {source, "row_step", std::to_string(cloud.row_step),
         fmt::format("{} points of {} bytes do not fit into a row", cloud.width, cloud.point_step),
         "set row_step = width * point_step in the driver"});
  }
  const std::uint64_t needed =
      cloud.height == 0 ? 0 : (std::uint64_t{cloud.height} - 1) * cloud.row_step + used;
  if (cloud.data.size() < needed) {
    throw InputError({source, "data", fmt::format("{} bytes", cloud.data.size()),
                      fmt::format("{} rows of {} bytes need {}", cloud.height, cloud.row_step, needed),
                      "see whether messages are cut on their way"});
  }
}

FieldType checked_type(const PointCloud2View& cloud, const PointCloud2Field& field,
                       const std::string& source) {
  const auto type = type_of(field.datatype);
  if (!type) {
    throw InputError({source, fmt::format("field {} datatype", field.name), std::to_string(field.datatype),
                      "not one of PointField's, 1 to 8", "see the driver's PointField"});
  }
  if (std::uint64_t{field.offset} + type->bytes > cloud.point_step) {
    throw InputError(
        {source, fmt::format("field {} offset", field.name), std::to_string(field.offset),
         fmt::format("its {} bytes reach beyond the point_step {}", type->bytes, cloud.point_step),
         "see the driver's PointField"});
  }
  return *type;
}

bool is_used(const PointCloud2Field& field) { return field.count == 1; }

// The points one after the other, without bytes between rows, and with little-endian numbers.
std::shared_ptr<const std::vector<std::uint8_t>> plain_copy(const PointCloud2View& cloud,
                                                            const std::string& source) {
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(cloud.height * row);
  for (std::size_t r = 0; r < cloud.height; ++r)
    std::memcpy(bytes->data() + r * row, cloud.data.data() + r * cloud.row_step, row);
  if (!cloud.is_bigendian) return bytes;
  for (const PointCloud2Field& field : cloud.fields) {
    if (!is_used(field)) continue;
    const std::uint32_t length = checked_type(cloud, field, source).bytes;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto first = bytes->begin() + static_cast<std::ptrdiff_t>(i * cloud.point_step + field.offset);
      std::reverse(first, first + length);
    }
  }
  return bytes;
}

}  // namespace

std::vector<NamedNumbers> named_numbers(const PointCloud2View& cloud, std::shared_ptr<const void>& owner,
                                        const std::string& source) {
  require_layout(cloud, source);
  const std::uint8_t* first = cloud.data.data();
  const bool has_gaps = cloud.height > 1 && cloud.row_step != std::uint64_t{cloud.width} * cloud.point_step;
  if (cloud.is_bigendian || has_gaps) {
    const auto copy = plain_copy(cloud, source);
    first = copy->data();
    owner = copy;
  }
  std::vector<NamedNumbers> numbers;
  for (const PointCloud2Field& field : cloud.fields) {
    if (!is_used(field)) continue;
    const FieldType type = checked_type(cloud, field, source);
    const std::uint8_t* at = cloud.size() > 0 ? first + field.offset : nullptr;
    numbers.push_back({field.name, {at, type.type, cloud.size(), cloud.point_step}});
  }
  return numbers;
}

DriverFields read_point_cloud2(const PointCloud2View& cloud, const std::string& source) {
  std::shared_ptr<const void> owner;
  const std::vector<NamedNumbers> numbers = named_numbers(cloud, owner, source);
  DriverFields found = driver_fields(numbers, std::max<std::uint32_t>(cloud.height, 1), source);
  found.owner = std::move(owner);
  return found;
}

}  // namespace mapless
