#include "io/formats/pcd/pcd.hpp"

#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

// Calls `use` with a zero of the field's own type.
template <class Use>
void with_type_of(const PcdField& field, Use use) {
  const bool is_signed = field.type == 'I';
  if (field.is_floating()) return field.size == 4 ? use(float{}) : use(double{});
  if (field.size == 1) return is_signed ? use(std::int8_t{}) : use(std::uint8_t{});
  if (field.size == 2) return is_signed ? use(std::int16_t{}) : use(std::uint16_t{});
  if (field.size == 4) return is_signed ? use(std::int32_t{}) : use(std::uint32_t{});
  return is_signed ? use(std::int64_t{}) : use(std::uint64_t{});
}

template <class Stored>
Stored stored_at(const PcdCloud& cloud, const PcdField& field, std::size_t point) {
  Stored value;
  std::memcpy(&value, cloud.bytes.data() + point * cloud.stride + field.offset, sizeof(value));
  return value;
}

template <class Number>
std::vector<Number> column(const PcdCloud& cloud, const PcdField& field) {
  std::vector<Number> out(cloud.size());
  with_type_of(field, [&](auto zero) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = static_cast<Number>(stored_at<decltype(zero)>(cloud, field, i));
    }
  });
  return out;
}

template <class Stored>
bool fits_int64(Stored value) {
  if constexpr (std::is_floating_point_v<Stored>) {
    return std::abs(value) < static_cast<Stored>(9.2e18) && std::trunc(value) == value;
  } else {
    return std::in_range<std::int64_t>(value);
  }
}

}  // namespace

void PcdCloud::add_field(std::string name, char type, std::size_t size, std::size_t count) {
  fields.push_back({std::move(name), type, size, count, stride});
  stride += size * count;
}

const PcdField* PcdCloud::find(std::string_view name) const {
  for (const PcdField& field : fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

const PcdField& PcdCloud::require(std::string_view name) const {
  const PcdField* field = find(name);
  if (field == nullptr) {
    throw InputError(
        {file.string(), "FIELDS", "", fmt::format("no field '{}'", name), "record it with the points"});
  }
  return *field;
}

std::vector<float> PcdCloud::floats(const PcdField& field) const { return column<float>(*this, field); }

std::vector<std::int64_t> PcdCloud::integers(const PcdField& field) const {
  std::vector<std::int64_t> out(size());
  with_type_of(field, [&](auto zero) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const auto value = stored_at<decltype(zero)>(*this, field, i);
      if (!fits_int64(value)) {
        throw InputError({file.string(), fmt::format("point {} {}", i, field.name), fmt::format("{}", value),
                          "not an integer", "record the field as integers"});
      }
      out[i] = static_cast<std::int64_t>(value);
    }
  });
  return out;
}

void write_pcd(const std::filesystem::path& file, const PcdCloud& cloud) {
  std::string names, sizes, types, counts;
  for (const PcdField& field : cloud.fields) {
    names += " " + field.name;
    sizes += fmt::format(" {}", field.size);
    types += fmt::format(" {}", field.type);
    counts += fmt::format(" {}", field.count);
  }
  const std::string header = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\nWIDTH {}\n"
      "HEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      names, sizes, types, counts, cloud.width, cloud.height, cloud.size());
  write_file_atomically(file, header + cloud.bytes);
}

}  // namespace mapless
