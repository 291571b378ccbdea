#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include <yaml-cpp/yaml.h>

namespace mapless::inline v1 {

/// One map of a YAML file, read key by key; whatever is wrong is an InputError naming file, line, key and
/// value.
class YamlMap {
 public:
  /// The map a file consists of.
  explicit YamlMap(const std::filesystem::path& file);
  /// A map inside it; `name` says which, in messages ("laser 3").
  YamlMap(const YAML::Node& node, std::string file, std::string name);

  [[nodiscard]] bool has(const std::string& key) const;
  /// Throws for a key that is not among these.
  void require_only(std::initializer_list<std::string_view> keys) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;
  [[nodiscard]] double number_or(const std::string& key, double absent) const;
  [[nodiscard]] int integer(const std::string& key) const;
  /// Degrees as radians, without rounding twice, so that radians_text reads back to the same double.
  [[nodiscard]] double degrees_as_radians(const std::string& key) const;
  /// `size` numbers in a row.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t size) const;
  /// A list of maps.
  [[nodiscard]] std::vector<YamlMap> maps(const std::string& key, const std::string& element_name) const;

  [[noreturn]] void refuse(const std::string& key, const std::string& problem) const;

 private:
  [[nodiscard]] YAML::Node scalar(const std::string& key) const;
  [[nodiscard]] double to_number(const YAML::Node& node, const std::string& key) const;
  [[nodiscard]] std::string where(const YAML::Node& node) const;
  [[nodiscard]] std::string field(const std::string& key) const;

  YAML::Node node_;
  std::string file_;
  std::string name_;
};

/// Radians as the shortest text in degrees that degrees_as_radians reads as the same double.
[[nodiscard]] std::string degrees_text(double radians);

}  // namespace mapless
