#include "benchmark/page/html.hpp"

#include <fmt/format.h>

#include "benchmark/page/page_style.hpp"
#include "benchmark/page/plot.hpp"
#include "reports/base64.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {

std::string html_page(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n"
      "<style>{}</style>\n</head>\n<body>\n<main>\n{}</main>\n{}</body>\n</html>\n",
      escaped(title), kPageStyle, body, plots_html());
}

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
