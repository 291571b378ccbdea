#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::app {

/// Escapes text and attribute values for HTML and SVG.
[[nodiscard]] std::string escaped(std::string_view text);

/// An <img> with the file inside it. Throws InputError.
[[nodiscard]] std::string inlined_png(const std::filesystem::path& file, std::string_view description);

/// A table that scrolls by itself where the screen is narrow. Cells are text, not HTML. The first
/// `text_columns` are words, the others numbers.
[[nodiscard]] std::string html_table(const std::vector<std::string>& head,
                                     const std::vector<std::vector<std::string>>& rows,
                                     std::size_t text_columns);

}  // namespace mapless::app
