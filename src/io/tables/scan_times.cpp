#include "io/tables/scan_times.hpp"

#include <optional>
#include <string>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {

std::vector<Time> read_scan_times(const std::filesystem::path& file, std::size_t scan_count) {
  const std::string text = read_whole_file(file);
  std::vector<Time> times;
  std::size_t line_number = 0;
  for (std::string_view line : split_lines(text)) {
    ++line_number;
    line = line.substr(0, line.find('#'));
    const std::vector<std::string_view> words = split_words(line);
    if (words.empty()) continue;
    const auto refuse = [&](const std::string& problem, const std::string& remedy) {
      throw InputError({fmt::format("{}:{}", file.string(), line_number), "time",
                        std::string(line.substr(0, 80)), problem, remedy});
    };
    const std::optional<Time> time = words.size() == 1 ? parse_decimal_seconds(words[0]) : std::nullopt;
    if (!time) refuse("not one number of seconds", "give the start of one scan a line");
    if (!times.empty() && *time <= times.back())
      refuse("not after the time before it", "put the scans in order");
    times.push_back(*time);
  }
  if (times.size() != scan_count) {
    throw InputError({file.string(), "times", std::to_string(times.size()),
                      fmt::format("not one for each of {} scans", scan_count),
                      "give the start of every scan"});
  }
  return times;
}

}  // namespace mapless
