#include <map>

#include <fmt/format.h>

#include "benchmark/page/html.hpp"
#include "benchmark/page/page_parts.hpp"

namespace mapless::app {
namespace {

struct Sum {
  std::int64_t tp = 0, fp = 0, fn = 0, tn = 0;

  void add(const Json& c) {
    tp += c["tp"].get<std::int64_t>();
    fp += c["fp"].get<std::int64_t>();
    fn += c["fn"].get<std::int64_t>();
    tn += c["tn"].get<std::int64_t>();
  }
};

struct FoundSum {
  std::int64_t found = 0, of = 0;

  void add(const Json& f) {
    if (!f.is_object()) return;
    found += f["found"].get<std::int64_t>();
    of += f["of"].get<std::int64_t>();
  }
};

std::string share(std::int64_t some, std::int64_t of) {
  return of == 0 ? "-" : rate_text(Json(static_cast<double>(some) / static_cast<double>(of)));
}

Cells sum_cells(const Sum& s) {
  return {share(s.tp, s.tp + s.fp),        share(s.tp, s.tp + s.fn), share(2 * s.tp, 2 * s.tp + s.fp + s.fn),
          share(s.tp, s.tp + s.fp + s.fn), count_text(s.tp + s.fn),  count_text(s.tp + s.fp)};
}

const Cells kSumHead = {"precision", "recall", "F1", "IoU", "moving points", "called dynamic"};

// A list that is null where the recording has no truth for it.
Json list(const Json& measures, const char* key) {
  const auto found = measures.find(key);
  return found != measures.end() && found->is_array() ? *found : Json::array();
}

// Numbers of points are whole: the band above 4 begins with 5.
std::string band_name(const Json& band, const std::string& unit) {
  const bool whole = unit == "points";
  const double from = band["above"].get<double>() + (whole ? 1 : 0);
  if (!band["up_to"].is_number())
    return whole ? fmt::format("{} {} or more", from, unit) : fmt::format("above {} {}", from, unit);
  return fmt::format("{} to {} {}", from, band["up_to"].get<double>(), unit);
}

std::string class_table(const std::vector<Json>& all) {
  struct OfClass {
    Sum points;
    FoundSum objects;
  };
  std::map<std::string, OfClass> classes;
  for (const Json& measures : all) {
    for (const Json& c : list(measures, "by_class")) {
      OfClass& sum = classes[c["class"].get<std::string>()];
      sum.points.add(c["points"]);
      sum.objects.add(c["objects"]);
    }
  }
  std::vector<Cells> body;
  for (const auto& [name, sum] : classes) {
    body.push_back(joined(joined({name}, sum_cells(sum.points)),
                          {share(sum.objects.found, sum.objects.of), count_text(sum.objects.of)}));
  }
  if (body.empty()) return "";
  return "<h3>By class</h3>\n" +
         html_table(joined(joined({"class"}, kSumHead), {"objects found", "objects in scans"}), body, 1);
}

std::string range_table(const std::vector<Json>& all) {
  std::vector<std::pair<std::string, Sum>> bands;
  for (const Json& measures : all) {
    std::size_t i = 0;
    for (const Json& band : list(measures, "by_range")) {
      if (i == bands.size()) bands.emplace_back(band_name(band, "m"), Sum());
      bands[i++].second.add(band);
    }
  }
  std::vector<Cells> body;
  for (const auto& [name, sum] : bands) body.push_back(joined({name}, sum_cells(sum)));
  return body.empty() ? "" : "<h3>By range</h3>\n" + html_table(joined({"range"}, kSumHead), body, 1);
}

std::string found_table(const std::vector<Json>& all, const char* key, const std::string& title,
                        const std::string& unit) {
  std::vector<std::pair<std::string, FoundSum>> bands;
  for (const Json& measures : all) {
    std::size_t i = 0;
    for (const Json& band : list(measures, key)) {
      if (i == bands.size()) bands.emplace_back(band_name(band, unit), FoundSum());
      bands[i++].second.add(band);
    }
  }
  std::vector<Cells> body;
  for (const auto& [name, sum] : bands) body.push_back({name, share(sum.found, sum.of), count_text(sum.of)});
  if (body.empty()) return "";
  return "<h3>" + escaped(title) + "</h3>\n" + html_table({"", "recall", "moving points"}, body, 1);
}

std::string object_table(const std::vector<Json>& rows) {
  std::vector<Cells> body;
  for (const Json& row : rows) {
    const Json& m = row["result"]["measures"];
    FoundSum objects, evident;
    objects.add(m["objects"]);
    evident.add(m["evident_movers"]);
    const Json& wrong = m["false_objects"];
    body.push_back({row["job"]["recording"]["scene"], share(objects.found, objects.of),
                    count_text(objects.of), share(evident.found, evident.of), count_text(evident.of),
                    rate_text(wrong["per_scan"]), count_text(wrong["objects"])});
  }
  return "<h3>By object</h3>\n" + html_table({"scene", "objects found", "of", "evident movers found", "of",
                                              "false objects per scan", "objects reported"},
                                             body, 1);
}

std::string sight_table(const std::vector<Json>& rows) {
  const auto cells = [](const Json& found) -> Cells {
    return {rate_text(found["share"]), count_text(found["of"])};
  };
  std::vector<Cells> body;
  for (const Json& row : rows) {
    const Json& sight = row["result"]["measures"]["sight"];
    body.push_back(joined(joined({row["job"]["recording"]["scene"]}, cells(sight["through_gap"])),
                          cells(sight["before_sky"])));
  }
  return "<h3>Hard to see</h3>\n" + html_table({"scene", "recall through a fence", "moving points",
                                                "recall with only sky behind", "moving points"},
                                               body, 1);
}

std::string delay_table(const std::vector<Json>& rows) {
  const auto cells = [](const Json& d) -> Cells {
    const auto scans = [](const Json& s) { return s.is_number() ? count_text(s) : std::string("-"); };
    return {scans(d["median_scans"]), scans(d["p90_scans"]), count_text(d["never"]), count_text(d["events"])};
  };
  std::vector<Cells> body;
  for (const Json& row : rows) {
    const Json& delays = row["result"]["measures"]["delays"];
    if (!delays.is_object()) continue;
    body.push_back(
        joined(joined({row["job"]["recording"]["scene"]}, cells(delays["start"])), cells(delays["stop"])));
  }
  if (body.empty()) return "";
  return "<h3>Delay of starts and stops, in scans</h3>\n" +
         html_table({"scene", "start: median", "90 %", "never", "of", "stop: median", "90 %", "never", "of"},
                    body, 1);
}

}  // namespace

std::string measure_tables(const Json& figures) {
  std::vector<Json> rows, all;
  for (const Json& row : main_rows(figures)) {
    if (!row["result"].contains("measures")) continue;
    rows.push_back(row);
    all.push_back(row["result"]["measures"]);
  }
  if (rows.empty()) return "";
  return object_table(rows) + class_table(all) + range_table(all) +
         found_table(all, "by_speed", "By true speed of the object", "m/s") +
         found_table(all, "by_visible_points", "By visible points of the object", "points") +
         sight_table(rows) + delay_table(rows);
}

}  // namespace mapless::app
