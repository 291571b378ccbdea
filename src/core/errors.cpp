#include <mapless/core/errors.hpp>

namespace mapless {
namespace {

std::string one_line(const ErrorDetail& detail) {
  std::string line;
  const auto append = [&line](const std::string& separator, const std::string& part) {
    if (part.empty()) return;
    if (!line.empty()) line += separator;
    line += part;
  };
  append("", detail.where);
  append(": ", detail.field);
  append(detail.field.empty() ? ": " : " = ", detail.value);
  append(": ", detail.problem);
  append("; ", detail.remedy);
  for (char& c : line) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return line;
}

}  // namespace

Error::Error(ErrorDetail detail) : std::runtime_error(one_line(detail)), detail_(std::move(detail)) {}

}  // namespace mapless
