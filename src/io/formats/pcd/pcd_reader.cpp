#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/formats/pcd/pcd.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t kMaxPoints = 1u << 28;
constexpr std::size_t kMaxCount = 1u << 16;
constexpr std::size_t kMaxStride = 1u << 20;
constexpr std::string_view kBlanks = " \t\r\v\f";  // as split_words has them

// The lines of a header, and what follows it.
struct Header {
  PcdCloud cloud;
  std::string encoding;
  std::string_view body;
};

class HeaderReader {
 public:
  HeaderReader(const std::filesystem::path& file, std::string_view bytes) : rest_(bytes) {
    cloud_.file = file;
  }

  Header read() {
    if (rest_.empty()) refuse("size", "0 bytes", "an empty file");
    while (encoding_.empty()) read_line();
    for (const char* key : {"FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT", "POINTS"}) {
      if (!seen_.contains(key)) refuse(key, "", "missing from the header");
    }
    lay_out_fields();
    if (points_ != cloud_.width * cloud_.height) {
      refuse("POINTS", std::to_string(points_),
             fmt::format("not WIDTH x HEIGHT = {} x {}", cloud_.width, cloud_.height));
    }
    return {std::move(cloud_), std::move(encoding_), rest_};
  }

 private:
  [[noreturn]] void refuse(std::string_view field, std::string_view value, const std::string& problem) const {
    throw InputError({cloud_.file.string(), std::string(field), std::string(value.substr(0, 80)), problem,
                      "write the scan again as PCD 0.7"});
  }

  void read_line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) refuse("DATA", "", "missing: the header does not end");
    const Words words = split_words(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    if (words.empty() || words[0].starts_with('#')) return;
    const std::string key(words[0]);
    if (!seen_.insert(key).second) refuse(key, "", "there twice");
    take(key, Words(words.begin() + 1, words.end()));
  }

  void take(const std::string& key, const Words& values) {
    if (key == "FIELDS")
      names_ = values;
    else if (key == "SIZE")
      sizes_ = values;
    else if (key == "TYPE")
      types_ = values;
    else if (key == "COUNT")
      counts_ = values;
    else if (key == "WIDTH")
      cloud_.width = one_number(key, values, kMaxPoints);
    else if (key == "HEIGHT")
      cloud_.height = one_number(key, values, kMaxPoints);
    else if (key == "POINTS")
      points_ = one_number(key, values, kMaxPoints);
    else if (key == "DATA")
      take_encoding(values);
    else if (key == "VERSION")
      require_version(values);
    else if (key != "VIEWPOINT")
      refuse(key, "", "not a key of a PCD header");
  }

  void take_encoding(const Words& values) {
    const std::string_view value = values.size() == 1 ? values[0] : "";
    if (value != "ascii" && value != "binary" && value != "binary_compressed") {
      refuse("DATA", value, "not ascii, binary or binary_compressed");
    }
    encoding_ = value;
  }

  void require_version(const Words& values) const {
    const std::string_view value = values.empty() ? "" : values[0];
    if (value != "0.7" && value != ".7") refuse("VERSION", value, "not 0.7");
  }

  std::size_t number(std::string_view key, std::string_view text, std::size_t max,
                     std::size_t min = 0) const {
    const auto value = parse_integer(text);
    if (!value || *value < static_cast<long long>(min) || *value > static_cast<long long>(max)) {
      refuse(key, text, fmt::format("not an integer from {} to {}", min, max));
    }
    return static_cast<std::size_t>(*value);
  }

  std::size_t one_number(const std::string& key, const Words& values, std::size_t max) const {
    if (values.size() != 1) refuse(key, "", "not one number");
    return number(key, values[0], max);
  }

  void lay_out_fields() {
    if (names_.empty()) refuse("FIELDS", "", "none named");
    if (counts_.empty()) counts_.assign(names_.size(), "1");
    const auto require_as_many = [this](const char* key, const Words& values) {
      if (values.size() != names_.size()) {
        refuse(key, fmt::format("{} values", values.size()),
               fmt::format("not one for each of {} FIELDS", names_.size()));
      }
    };
    require_as_many("SIZE", sizes_);
    require_as_many("TYPE", types_);
    require_as_many("COUNT", counts_);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const std::size_t size = number("SIZE", sizes_[i], 8);
      const std::string_view type = types_[i];
      if (type != "I" && type != "U" && type != "F") refuse("TYPE", type, "not I, U or F");
      const bool fits =
          type == "F" ? size == 4 || size == 8 : size == 1 || size == 2 || size == 4 || size == 8;
      if (!fits) refuse("SIZE", sizes_[i], fmt::format("no size of a field of type {}", type));
      cloud_.add_field(std::string(names_[i]), type[0], size, number("COUNT", counts_[i], kMaxCount, 1));
    }
    if (cloud_.stride == 0 || cloud_.stride > kMaxStride) {
      refuse("SIZE x COUNT", std::to_string(cloud_.stride),
             fmt::format("not from 1 to {} bytes a point", kMaxStride));
    }
  }

  std::string_view rest_;
  PcdCloud cloud_;
  std::string encoding_;
  std::set<std::string> seen_;
  Words names_, sizes_, types_, counts_;
  std::size_t points_ = 0;
};

[[noreturn]] void refuse_body(const PcdCloud& cloud, const std::string& field, const std::string& value,
                              const std::string& problem) {
  throw InputError({cloud.file.string(), field, value, problem,
                    "the file is cut off or its header is another's: copy or record it again"});
}

void read_binary(PcdCloud& cloud, std::string_view body) {
  const std::size_t expected = cloud.size() * cloud.stride;
  if (body.size() < expected || body.size() >= expected + cloud.stride) {
    refuse_body(cloud, "DATA", fmt::format("{} bytes", body.size()),
                fmt::format("not POINTS x bytes a point = {} x {}", cloud.size(), cloud.stride));
  }
  cloud.bytes = body.substr(0, expected);
}

// Compressed bodies hold each field of all points together; here they are one point after the other.
void interleave(PcdCloud& cloud, const std::string& by_field) {
  cloud.bytes.resize(by_field.size());
  const char* from = by_field.data();
  for (const PcdField& field : cloud.fields) {
    const std::size_t width = field.size * field.count;
    for (std::size_t i = 0; i < cloud.size(); ++i, from += width) {
      std::memcpy(cloud.bytes.data() + i * cloud.stride + field.offset, from, width);
    }
  }
}

void read_compressed(PcdCloud& cloud, std::string_view body) {
  std::uint32_t sizes[2] = {0, 0};
  if (body.size() < sizeof(sizes))
    refuse_body(cloud, "DATA", fmt::format("{} bytes", body.size()), "cut off");
  std::memcpy(sizes, body.data(), sizeof(sizes));
  body.remove_prefix(sizeof(sizes));
  if (sizes[1] != cloud.size() * cloud.stride) {
    refuse_body(cloud, "DATA", fmt::format("{} bytes uncompressed", sizes[1]),
                fmt::format("not POINTS x bytes a point = {} x {}", cloud.size(), cloud.stride));
  }
  std::string by_field;
  if (body.size() < sizes[0] || !lzf_decompress(body.substr(0, sizes[0]), sizes[1], by_field)) {
    refuse_body(cloud, "DATA", fmt::format("{} bytes compressed", body.size()), "cut off or damaged");
  }
  interleave(cloud, by_field);
}

template <class Stored>
bool store(std::string_view text, char* to) {
  Stored value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return false;
  std::memcpy(to, &value, sizeof(value));
  return true;
}

bool store_as(const PcdField& field, std::string_view text, char* to) {
  const bool is_signed = field.type == 'I';
  if (field.is_floating()) return field.size == 4 ? store<float>(text, to) : store<double>(text, to);
  if (field.size == 1) return is_signed ? store<std::int8_t>(text, to) : store<std::uint8_t>(text, to);
  if (field.size == 2) return is_signed ? store<std::int16_t>(text, to) : store<std::uint16_t>(text, to);
  if (field.size == 4) return is_signed ? store<std::int32_t>(text, to) : store<std::uint32_t>(text, to);
  return is_signed ? store<std::int64_t>(text, to) : store<std::uint64_t>(text, to);
}

void read_ascii_point(PcdCloud& cloud, std::size_t point, const Words& words) {
  char* to = cloud.bytes.data() + point * cloud.stride;
  std::size_t word = 0;
  for (const PcdField& field : cloud.fields) {
    for (std::size_t c = 0; c < field.count; ++c, ++word) {
      const auto refuse = [&](const std::string& value, const std::string& problem) {
        refuse_body(cloud, fmt::format("point {} {}", point, field.name), value, problem);
      };
      if (word >= words.size()) refuse("", "missing");
      if (!store_as(field, words[word], to + field.offset + c * field.size)) {
        refuse(std::string(words[word].substr(0, 80)),
               fmt::format("not of type {}{}", field.type, field.size));
      }
    }
  }
  if (word != words.size()) {
    refuse_body(cloud, fmt::format("point {}", point), fmt::format("{} values", words.size()),
                fmt::format("not {}, as FIELDS and COUNT define", word));
  }
}

// Every number takes a digit and a separator. COUNT could claim gigabytes for rows of one number.
void require_room_for_numbers(const PcdCloud& cloud, std::string_view body) {
  std::size_t numbers = 0;
  for (const PcdField& field : cloud.fields) numbers += field.count;
  if (2 * numbers * cloud.size() <= body.size() + 1) return;
  refuse_body(cloud, "DATA", fmt::format("{} bytes", body.size()),
              fmt::format("no room for {} points of {} numbers", cloud.size(), numbers));
}

void read_ascii(PcdCloud& cloud, std::string_view body) {
  std::vector<std::string_view> rows;
  for (const std::string_view line : split_lines(body)) {
    if (line.find_first_not_of(kBlanks) != std::string_view::npos) rows.push_back(line);
  }
  if (rows.size() != cloud.size()) {
    refuse_body(cloud, "DATA", fmt::format("{} rows", rows.size()),
                fmt::format("not POINTS = {}", cloud.size()));
  }
  require_room_for_numbers(cloud, body);
  cloud.bytes.assign(cloud.size() * cloud.stride, '\0');
  for (std::size_t i = 0; i < rows.size(); ++i) read_ascii_point(cloud, i, split_words(rows[i]));
}

}  // namespace

PcdCloud read_pcd(const std::filesystem::path& file) {
  const std::string bytes = read_whole_file(file);
  Header header = HeaderReader(file, bytes).read();
  if (header.encoding == "ascii") {
    read_ascii(header.cloud, header.body);
  } else if (header.encoding == "binary") {
    read_binary(header.cloud, header.body);
  } else {
    read_compressed(header.cloud, header.body);
  }
  return std::move(header.cloud);
}

}  // namespace mapless
