#include "benchmark/speed/speed_sensor.hpp"

#include <charconv>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

constexpr int kMostColumns = 8192;

std::optional<int> whole(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

// All lasers of an OS1 fire at once, so that its columns can be as many as one likes; those of the others
// fire in turn, which takes its time.
LidarModel speed_sensor(const std::string& name) {
  const std::size_t x = name.starts_with("OS1-") ? name.rfind('x') : std::string::npos;
  if (x == std::string::npos) return named_model(name);
  const auto columns = whole(std::string_view(name).substr(x + 1));
  if (!columns || *columns < 1 || *columns > kMostColumns) {
    throw ParameterError({"--sensors", "columns", name, fmt::format("must be 1 to {}", kMostColumns),
                          "give for example OS1-128x2048"});
  }
  LidarModel model = named_model(name.substr(0, x));
  model.name = name;
  model.columns = *columns;
  return model;
}

}  // namespace mapless::app
