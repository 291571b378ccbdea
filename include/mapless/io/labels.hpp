#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace mapless::inline v1 {

/// Labels of the SemanticKITTI moving-object convention: low 16 bits the class, high 16 bits the object.
inline constexpr std::uint32_t kLabelUnknown = 0;
inline constexpr std::uint32_t kLabelStatic = 9;
inline constexpr std::uint32_t kLabelDynamic = 251;

/// The number of an object in a label, of which 16 bits hold fewer than there are ids: 1 to 65535, again and
/// again.
[[nodiscard]] constexpr std::uint16_t label_number(std::uint32_t id) {
  return static_cast<std::uint16_t>((id - 1) % 65535u + 1);
}

/// SemanticKITTI counts 251 to 259 (any moving class) as moving; 0 and 1 (outlier) as unlabelled.
enum class MotionTruth { unknown, still, moving };
[[nodiscard]] constexpr MotionTruth motion_of_label(std::uint32_t label) {
  const std::uint32_t c = label & 0xFFFFu;
  if (c >= 251 && c <= 259) return MotionTruth::moving;
  return c <= 1 ? MotionTruth::unknown : MotionTruth::still;
}

/// Throws InputError for a file that cannot be read or whose length is not `expected_count` x 4 bytes.
[[nodiscard]] std::vector<std::uint32_t> read_label_file(const std::filesystem::path& file,
                                                         std::size_t expected_count);

/// Writes beside and renames. Throws OutputError.
void write_label_file(const std::filesystem::path& file, const std::vector<std::uint32_t>& labels);

}  // namespace mapless
