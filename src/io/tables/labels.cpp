#include <bit>
#include <cstring>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::uint32_t kLastClass = 259;  // of SemanticKITTI: another moving vehicle

}  // namespace

// Label files are little-endian, and read and written without turning bytes round.
static_assert(std::endian::native == std::endian::little);

std::vector<std::uint32_t> read_label_file(const std::filesystem::path& file, std::size_t expected_count) {
  const std::string bytes = read_whole_file(file);
  if (bytes.size() != expected_count * sizeof(std::uint32_t)) {
    throw InputError({file.string(), "size", fmt::format("{} bytes", bytes.size()),
                      fmt::format("not 4 bytes for each of the scan's {} points", expected_count),
                      "use the labels of this very scan"});
  }
  std::vector<std::uint32_t> labels(expected_count);
  if (!labels.empty()) std::memcpy(labels.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::uint32_t c = labels[i] & 0xFFFFu;
    if (c <= kLastClass) continue;
    throw InputError({file.string(), fmt::format("label of record {}", i), fmt::format("class {}", c),
                      fmt::format("not a class of SemanticKITTI, 0 to {}", kLastClass),
                      "give labels as mapless detect or SemanticKITTI write them"});
  }
  return labels;
}

void write_label_file(const std::filesystem::path& file, const std::vector<std::uint32_t>& labels) {
  std::string bytes(labels.size() * sizeof(std::uint32_t), '\0');
  if (!labels.empty()) std::memcpy(bytes.data(), labels.data(), bytes.size());
  write_file_atomically(file, bytes);
}

}  // namespace mapless
