#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::app {

/// A page that loads nothing, in the style of all pages of the benchmark. `title` is text, `body` HTML, in
/// which the figures of plots are drawn (plot.hpp).
[[nodiscard]] std::string html_page(std::string_view title, std::string_view body);

/// Escapes text and attribute values for HTML.
[[nodiscard]] std::string escaped(std::string_view text);

/// An <img> with the file inside it. Throws InputError.
[[nodiscard]] std::string inlined_png(const std::filesystem::path& file, std::string_view description);

/// A table that scrolls by itself where the screen is narrow. Cells are text, not HTML. The first
/// `text_columns` are words, the others numbers.
[[nodiscard]] std::string html_table(const std::vector<std::string>& head,
                                     const std::vector<std::vector<std::string>>& rows,
                                     std::size_t text_columns);

}  // namespace mapless::app
