#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include <yaml-cpp/yaml.h>

namespace mapless::inline v1 {

/// One map of a YAML file, read key by key. Every error is an InputError naming file, line, key and value.
class YamlMap {
 public:
  /// The top-level map of a file.
  explicit YamlMap(const std::filesystem::path& file);
  /// A map inside `file`; `name` is its name in messages ("laser 3").
  YamlMap(const YAML::Node& node, std::string file, std::string name);

  [[nodiscard]] bool has(const std::string& key) const;
  /// Throws for a key that is not in the list, and for one that is there twice.
  void require_only(std::initializer_list<std::string_view> keys) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key) const;
  [[nodiscard]] double number_or(const std::string& key, double absent) const;
  [[nodiscard]] int integer(const std::string& key) const;
  /// The value, in degrees, converted to radians such that degrees_text gives the same double back.
  [[nodiscard]] double degrees_as_radians(const std::string& key) const;
  /// A list of `size` numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t size) const;
  /// A list of one or more numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& key) const;
  /// A map within this one.
  [[nodiscard]] YamlMap map(const std::string& key) const;
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

/// Radians as the shortest text in degrees that degrees_as_radians converts to the same double.
[[nodiscard]] std::string degrees_text(double radians);

}  // namespace mapless
