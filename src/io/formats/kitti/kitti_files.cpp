#include "io/formats/kitti/kitti_files.hpp"

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Reads the digits at the front of `text`, exactly `count` of them (any number where 0), and takes them off.
std::optional<long> take_digits(std::string_view& text, std::size_t count) {
  std::size_t length = 0;
  while (length < text.size() && text[length] >= '0' && text[length] <= '9') ++length;
  if (length == 0 || length > 9 || (count != 0 && length != count)) return std::nullopt;
  long value = 0;
  std::from_chars(text.data(), text.data() + length, value);
  text.remove_prefix(length);
  return value;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

std::optional<Time> date_time(std::string_view text) {
  const auto year = take_digits(text, 4);
  if (!year || !take(text, '-')) return std::nullopt;
  const auto month = take_digits(text, 2);
  if (!month || !take(text, '-')) return std::nullopt;
  const auto day = take_digits(text, 2);
  if (!day || !take(text, ' ')) return std::nullopt;
  const auto hour = take_digits(text, 2);
  if (!hour || !take(text, ':')) return std::nullopt;
  const auto minute = take_digits(text, 2);
  if (!minute || !take(text, ':')) return std::nullopt;
  const auto second = take_digits(text, 2);
  if (!second || *hour > 23 || *minute > 59 || *second > 60) return std::nullopt;
  long nanoseconds = 0;
  if (take(text, '.')) {
    const std::size_t before = text.size();
    const auto fraction = take_digits(text, 0);
    if (!fraction) return std::nullopt;
    nanoseconds = *fraction;
    for (std::size_t digits = before - text.size(); digits < 9; ++digits) nanoseconds *= 10;
  }
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  // Within 126 years of 1970 (Time::kLargestOutside_ns).
  if (!text.empty() || !date.ok() || *year < 1850 || *year > 2090) return std::nullopt;
  const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  const std::int64_t seconds = ((days * 24 + *hour) * 60 + *minute) * 60 + *second;
  return Time::from_nanoseconds(seconds * 1'000'000'000 + nanoseconds);
}

// Mean step between one number and that of the same column in the next row. Neighbouring points are near each
// other, so that the true number of columns gives the least.
double mean_step(const std::vector<float>& numbers, std::size_t columns) {
  double sum = 0;
  for (std::size_t i = columns; i < numbers.size(); ++i)
    sum += std::abs(double{numbers[i]} - double{numbers[i - columns]});
  return sum / static_cast<double>(numbers.size() - columns);
}

// Five floats a point, as nuScenes has them, read as four are points all over the place.
void require_four_columns(const std::string& bytes, const fs::path& file) {
  constexpr std::size_t five = 5 * sizeof(float);
  if (bytes.size() % five != 0 || bytes.size() < 2 * five) return;
  std::vector<float> numbers(bytes.size() / sizeof(float));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  if (!(2 * mean_step(numbers, 5) < mean_step(numbers, 4))) return;
  throw InputError({file.string(), "columns", "five floats a point", "KITTI has four: x, y, z, reflectance",
                    "name them with the Python package: --columns x,y,z,intensity,ring"});
}

}  // namespace

std::vector<Eigen::Vector3f> read_kitti_cloud(const fs::path& file) {
  constexpr std::size_t row = 4 * sizeof(float);
  const std::string bytes = read_whole_file(file);
  if (bytes.empty()) {
    throw InputError({file.string(), "size", "0 bytes", "no points", "fetch the file again, or remove it"});
  }
  require_four_columns(bytes, file);
  if (bytes.size() % row != 0) {
    throw InputError({file.string(), "size", fmt::format("{} bytes", bytes.size()),
                      "not a multiple of 16 (float32 x, y, z, reflectance): truncated or of another format",
                      "fetch the file again"});
  }
  std::vector<Eigen::Vector3f> points(bytes.size() / row);
  for (std::size_t i = 0; i < points.size(); ++i)
    std::memcpy(points[i].data(), &bytes[i * row], 3 * sizeof(float));
  return points;
}

Time parse_date_time(const std::string& text, const std::string& where) {
  const std::optional<Time> time = date_time(text);
  if (!time) {
    throw InputError({where, "time", text.empty() ? "empty line" : text, "not YYYY-MM-DD hh:mm:ss.fffffffff",
                      "restore the line from the original recording"});
  }
  return *time;
}

}  // namespace mapless
