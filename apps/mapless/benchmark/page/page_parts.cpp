#include "benchmark/page/page_parts.hpp"

#include <fmt/format.h>

#include "benchmark/page/html.hpp"

namespace mapless::app {

Cells joined(Cells first, const Cells& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::string rate_text(const Json& rate) {
  return rate.is_number() ? fmt::format("{:.3f}", rate.get<double>()) : "-";
}

std::string count_text(const Json& count) {
  if (!count.is_number()) return "-";
  const std::string digits = std::to_string(count.get<std::int64_t>());
  std::string out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) out += ',';
    out += digits[i];
  }
  return out;
}

std::string run_name(const Json& job) {
  const Json& r = job["recording"];
  return fmt::format("{}, {}, noise {} m, seed {}", r["scene"].get<std::string>(),
                     r["sensor"].get<std::string>(), r["range_noise_m"].get<double>(),
                     r["seed"].get<std::uint64_t>());
}

std::vector<Json> rows_of(const Json& figures, const std::string& part) {
  std::vector<Json> out;
  for (const Json& row : figures["rows"]) {
    if (row["job"]["part"] == part) out.push_back(row);
  }
  return out;
}

std::vector<Json> main_rows(const Json& figures) {
  std::vector<Json> out;
  for (const Json& row : rows_of(figures, "table")) {
    const Json& job = row["job"];
    if (job["poses"] != "true") continue;
    const auto same = [&](const char* key) {
      return job["recording"][key] == (out.empty() ? job : out.front()["job"])["recording"][key];
    };
    if (same("sensor") && same("range_noise_m") && same("seed")) out.push_back(row);
  }
  return out;
}

std::string pictures(const Json& figures, const BenchmarkFolder& folder, const std::string& kind,
                     std::size_t rows) {
  std::string out;
  std::size_t shown = 0;
  for (const Json& row : rows_of(figures, "table")) {
    std::string of_row;
    for (const Json& picture : row["result"].value("pictures", Json::array())) {
      if (picture["kind"] != kind) continue;
      const auto caption = picture["caption"].get<std::string>();
      of_row += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                            inlined_png(folder.pictures() / picture["file"].get<std::string>(), caption),
                            escaped(caption));
    }
    if (of_row.empty()) continue;
    if (shown++ == rows) break;
    if (rows > 1)
      out += fmt::format("<h3>{}</h3>\n", escaped(row["job"]["recording"]["scene"].get<std::string>()));
    out += fmt::format("<div class=\"{}\">\n{}</div>\n", kind, of_row);
  }
  return out;
}

}  // namespace mapless::app
