#include <cstddef>
#include <utility>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kLongestPart = 200;

// Whether the byte goes on a character of UTF-8 that another began.
bool goes_on_a_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

// Of a binary file read as text, the line may be all of it.
std::string shortened(const std::string& part) {
  if (part.size() <= kLongestPart) return part;
  std::size_t end = kLongestPart;
  while (end > kLongestPart - 4 && goes_on_a_character(part[end])) --end;
  return part.substr(0, end) + "...";
}

// A zero would end the message, and an escape sequence be obeyed by the terminal.
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
  append("", detail.where);
  append(": ", shortened(detail.field));
  append(detail.field.empty() ? ": " : " = ", shortened(detail.value));
  append(": ", detail.problem);
  append("; ", detail.remedy);
  make_printable(line);
  return line;
}

}  // namespace

Error::Error(ErrorDetail detail) : std::runtime_error(one_line(detail)), detail_(std::move(detail)) {}

}  // namespace mapless
