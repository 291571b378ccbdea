#include "benchmark/page/html.hpp"

#include <cstdint>

#include <fmt/format.h>

#include <mapless/io/files.hpp>

namespace mapless::app {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      three <<= 8U;
      if (i + j < bytes.size()) three |= static_cast<unsigned char>(bytes[i + j]);
    }
    for (std::size_t digit = 0; digit < 4; ++digit) {
      const bool is_padding = i + digit > bytes.size();
      out += is_padding ? '=' : kDigits[three >> (18 - 6 * digit) & 63U];
    }
  }
  return out;
}

std::string inlined_png(const std::filesystem::path& file, std::string_view description) {
  return fmt::format(R"(<img loading="lazy" alt="{}" src="data:image/png;base64,{}">)", escaped(description),
                     base64(read_whole_file(file)));
}

std::string html_table(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows, std::size_t text_columns) {
  const auto row_html = [&](const std::vector<std::string>& cells, const char* tag) {
    std::string out = "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i)
      out += fmt::format("<{0}{1}>{2}</{0}>", tag, i < text_columns ? " class=\"w\"" : "", escaped(cells[i]));
    return out + "</tr>\n";
  };
  std::string out = "<div class=\"scroll\"><table>\n<thead>" + row_html(head, "th") + "</thead>\n<tbody>\n";
  for (const auto& row : rows) out += row_html(row, "td");
  return out + "</tbody></table></div>\n";
}

}  // namespace mapless::app
