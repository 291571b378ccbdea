#include "io/files/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

// Wider than double: a double in degrees cannot name every double in radians.
std::optional<double> radians_of(std::string_view degrees) {
  if (degrees.starts_with('+')) degrees.remove_prefix(1);
  long double value = 0;
  const auto [end, error] = std::from_chars(degrees.data(), degrees.data() + degrees.size(), value);
  if (error != std::errc() || end != degrees.data() + degrees.size()) return std::nullopt;
  return static_cast<double>(value * (std::numbers::pi_v<long double> / 180));
}

YAML::Node load(const std::filesystem::path& file) {
  try {
    return YAML::Load(read_whole_file(file));
  } catch (const YAML::Exception& error) {
    throw InputError({fmt::format("{}:{}", file.string(), error.mark.line + 1), "", "",
                      "not YAML: " + error.msg, "correct the file"});
  }
}

}  // namespace

YamlMap::YamlMap(const std::filesystem::path& file) : YamlMap(load(file), file.string(), "") {}

YamlMap::YamlMap(const YAML::Node& node, std::string file, std::string name)
    : node_(node), file_(std::move(file)), name_(std::move(name)) {
  if (!node_.IsMap()) {
    throw InputError({where(node_), name_, "", "not a list of keys and values", "see the documented format"});
  }
}

std::string YamlMap::where(const YAML::Node& node) const {
  if (!node.IsDefined() || node.Mark().is_null()) return file_;
  return fmt::format("{}:{}", file_, node.Mark().line + 1);
}

std::string YamlMap::field(const std::string& key) const { return name_.empty() ? key : name_ + " " + key; }

bool YamlMap::has(const std::string& key) const { return node_[key].IsDefined(); }

void YamlMap::refuse(const std::string& key, const std::string& problem) const {
  const YAML::Node value = node_[key];
  const bool shown = value.IsDefined() && value.IsScalar();
  throw InputError({where(value.IsDefined() ? value : node_), field(key), shown ? value.Scalar() : "",
                    problem, "correct the file"});
}

void YamlMap::require_only(std::initializer_list<std::string_view> keys) const {
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    if (!seen.insert(key).second)
      throw InputError({where(entry.first), field(key), "", "there twice", "keep one of them"});
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw InputError(
        {where(entry.first), field(key), "", "unknown key", fmt::format("use {}", fmt::join(keys, ", "))});
  }
}

YAML::Node YamlMap::scalar(const std::string& key) const {
  YAML::Node value = node_[key];
  if (!value.IsDefined()) refuse(key, "missing");
  if (!value.IsScalar()) refuse(key, "not a single value");
  return value;
}

double YamlMap::to_number(const YAML::Node& node, const std::string& key) const {
  const std::optional<double> value = node.IsScalar() ? parse_double(node.Scalar()) : std::nullopt;
  if (!value) refuse(key, "not a number");
  if (!std::isfinite(*value)) refuse(key, "not finite");
  return *value;
}

std::string YamlMap::text(const std::string& key) const { return scalar(key).Scalar(); }

double YamlMap::number(const std::string& key) const { return to_number(scalar(key), key); }

double YamlMap::number_or(const std::string& key, double absent) const {
  return has(key) ? number(key) : absent;
}

int YamlMap::integer(const std::string& key) const {
  const std::optional<long long> value = parse_integer(text(key));
  if (!value || std::abs(*value) > 1'000'000'000) refuse(key, "not an integer");
  return static_cast<int>(*value);
}

double YamlMap::degrees_as_radians(const std::string& key) const {
  (void)number(key);
  return radians_of(text(key)).value_or(0);
}

std::vector<double> YamlMap::numbers(const std::string& key, std::size_t size) const {
  const YAML::Node list = node_[key];
  if (!list.IsDefined()) refuse(key, "missing");
  if (!list.IsSequence() || list.size() != size) refuse(key, fmt::format("not a list of {} numbers", size));
  std::vector<double> values;
  for (const YAML::Node& element : list) values.push_back(to_number(element, key));
  return values;
}

std::vector<double> YamlMap::numbers(const std::string& key) const {
  const YAML::Node list = node_[key];
  if (!list.IsDefined()) refuse(key, "missing");
  if (!list.IsSequence() || list.size() == 0) refuse(key, "not a list with anything in it");
  return numbers(key, list.size());
}

YamlMap YamlMap::map(const std::string& key) const { return {node_[key], file_, field(key)}; }

std::vector<YamlMap> YamlMap::maps(const std::string& key, const std::string& element_name) const {
  const YAML::Node list = node_[key];
  if (!list.IsDefined()) refuse(key, "missing");
  if (!list.IsSequence() || list.size() == 0) refuse(key, "not a list with anything in it");
  std::vector<YamlMap> out;
  for (const YAML::Node& element : list) {
    out.emplace_back(element, file_, fmt::format("{} {}", element_name, out.size()));
  }
  return out;
}

std::string degrees_text(double radians) {
  const long double degrees = radians / (std::numbers::pi_v<long double> / 180);
  std::string text;
  for (int digits = 15; digits <= 21; ++digits) {
    text = fmt::format("{:.{}g}", degrees, digits);
    if (radians_of(text) == radians) break;
  }
  return text;
}

}  // namespace mapless
