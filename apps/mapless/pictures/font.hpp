#pragma once

#include <array>
#include <cstdint>

namespace mapless::app {

inline constexpr int kLetterRows = 7;
inline constexpr int kLetterColumns = 5;

/// The dots of a letter, top row first, the leftmost dot in bit 4.
using LetterRows = std::array<std::uint8_t, kLetterRows>;

/// A blank for characters that the font does not have.
[[nodiscard]] LetterRows letter_rows(char letter);

}  // namespace mapless::app
