#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace mapless::inline v1 {

/// Labels of the SemanticKITTI moving-object convention: class in the low 16 bits, object number in the high
/// 16 bits.
inline constexpr std::uint32_t kLabelUnknown = 0;
inline constexpr std::uint32_t kLabelStatic = 9;
inline constexpr std::uint32_t kLabelDynamic = 251;

/// Object number in a label for the object id >= 1: ids beyond 65535 start again at 1.
[[nodiscard]] constexpr std::uint16_t label_number(std::uint32_t id) {
  return static_cast<std::uint16_t>((id - 1) % 65535u + 1);
}

/// Motion state of a label: classes 251 to 259 (any moving class) are moving; 0 and 1 (outlier) are unknown.
enum class MotionTruth { unknown, still, moving };
[[nodiscard]] constexpr MotionTruth motion_of_label(std::uint32_t label) {
  const std::uint32_t c = label & 0xFFFFu;
  if (c >= 251 && c <= 259) return MotionTruth::moving;
  return c <= 1 ? MotionTruth::unknown : MotionTruth::still;
}

/// Reads a label file: one little-endian uint32 per input record. Throws InputError for a file that cannot be
/// read or whose length is not `expected_count` x 4 bytes.
[[nodiscard]] std::vector<std::uint32_t> read_label_file(const std::filesystem::path& file,
                                                         std::size_t expected_count);

/// Writes a label file atomically (write_file_atomically). Throws OutputError.
void write_label_file(const std::filesystem::path& file, const std::vector<std::uint32_t>& labels);

}  // namespace mapless
