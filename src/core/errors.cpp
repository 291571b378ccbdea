#include <cerrno>
#include <cstddef>
#include <utility>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Keeps a message readable where a binary file is read as text and one line is the whole file [bytes].
constexpr std::size_t kLongestPart = 200;
// A sentence, with a value or a reason of the system in it.
constexpr std::size_t kLongestProblem = 600;
// A UTF-8 character has at most this many continuation bytes.
constexpr std::size_t kMostContinuationBytes = 3;

// A path of any file system's longest name (255) and some folders stays whole; of a longer one, both ends.
constexpr std::size_t kLongestPlace = 400, kStartOfPlace = 100;

// True for a continuation byte of UTF-8: 10xxxxxx.
bool is_continuation(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

// Cut between two UTF-8 characters.
std::string shortened(const std::string& part, std::size_t longest = kLongestPart) {
  if (part.size() <= longest) return part;
  std::size_t end = longest;
  while (end > longest - kMostContinuationBytes - 1 && is_continuation(part[end])) --end;
  return part.substr(0, end) + "...";
}

// Cut in the middle, between two UTF-8 characters: the end of a path names the file.
std::string shortened_place(const std::string& place) {
  if (place.size() <= kLongestPlace) return place;
  std::size_t first = kStartOfPlace, second = place.size() - (kLongestPlace - kStartOfPlace);
  while (first > 0 && is_continuation(place[first])) --first;
  while (second < place.size() && is_continuation(place[second])) ++second;
  return place.substr(0, first) + "..." + place.substr(second);
}

// A zero byte would end the message, and a terminal would execute an escape sequence.
void make_printable(std::string& line) {
  for (char& c : line) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
}

std::string one_line(const ErrorDetail& detail) {
  std::string line;
  const auto append = [&line](const std::string& separator, const std::string& part) {
    if (part.empty()) return;
    if (!line.empty()) line += separator;
    line += part;
  };
  append("", shortened_place(detail.where));
  append(": ", shortened(detail.field));
  append(detail.field.empty() ? ": " : " = ", shortened(detail.value));
  append(": ", shortened(detail.problem, kLongestProblem));
  append("; ", detail.remedy);
  make_printable(line);
  return line;
}

bool is_absent(const std::error_code& reason) {
  return reason == std::errc::no_such_file_or_directory || reason == std::errc::not_a_directory ||
         reason == std::errc::is_a_directory;
}

bool is_full(const std::error_code& reason) {
  return reason == std::errc::no_space_on_device ||
         reason == std::error_code(EDQUOT, std::generic_category());
}

}  // namespace

Error::Error(ErrorDetail detail) : std::runtime_error(one_line(detail)), detail_(std::move(detail)) {}

void throw_read_error(ErrorDetail detail, const std::error_code& reason) {
  if (is_absent(reason)) throw InputError(std::move(detail));
  throw AccessError(std::move(detail));
}

void throw_write_error(ErrorDetail detail, const std::error_code& reason) {
  if (is_full(reason)) throw TemporaryError(std::move(detail));
  throw OutputError(std::move(detail));
}

}  // namespace mapless
