#include <algorithm>

#include <fmt/format.h>

#include "benchmark/page/html.hpp"
#include "benchmark/page/page_parts.hpp"

namespace mapless::app {
namespace {

std::string number_text(const Json& number) { return fmt::format("{}", number.get<double>()); }

std::string with_n(const Json& rate, const Json& n) {
  return fmt::format("{} ({})", rate_text(rate), count_text(n));
}

Cells rate_cells(const Json& rates) {
  return {rate_text(rates["precision"]),
          rate_text(rates["recall"]),
          rate_text(rates["f1"]),
          rate_text(rates["iou"]),
          with_n(rates["average_precision"], rates["n_p"]),
          with_n(rates["average_recall"], rates["n_r"])};
}

constexpr std::ptrdiff_t kAfterIou = 4 + 4;  // in the table of results
const Cells kRateHead = {"precision", "recall", "F1", "IoU", "avg. precision (N)", "avg. recall (N)"};

// The number of points that recall is computed from.
Cells count_cells(const Json& rates) {
  return {count_text(rates["scans"]),
          count_text(rates["tp"].get<std::int64_t>() + rates["fn"].get<std::int64_t>())};
}

const Json* with_odometry(const std::vector<Json>& rows, const Json& row) {
  for (const Json& other : rows) {
    if (other["job"]["poses"] != "true" && other["job"]["recording"] == row["job"]["recording"])
      return &other["result"]["final"];
  }
  return nullptr;
}

}  // namespace

std::string results_table(const Json& figures) {
  const bool odometry = figures["odometry"];
  const auto rows = rows_of(figures, "table");
  Cells head = joined({"scene", "sensor", "noise [m]", "seed"}, kRateHead);
  if (odometry) head.insert(head.begin() + kAfterIou, {"IoU, own odometry", "difference"});
  head = joined(head, {"scans", "moving points"});
  std::vector<Cells> body;
  std::string troubles;
  for (const Json& row : rows) {
    if (const std::string trouble = row["result"]["odometry_trouble"]; !trouble.empty())
      troubles +=
          fmt::format("<p class=\"soft\">{}: {}</p>\n", escaped(run_name(row["job"])), escaped(trouble));
    if (row["job"]["poses"] != "true") continue;
    const Json& r = row["job"]["recording"];
    const Json& rates = row["result"]["final"];
    Cells cells = joined({r["scene"], r["sensor"], number_text(r["range_noise_m"]), count_text(r["seed"])},
                         rate_cells(rates));
    if (const Json* own = odometry ? with_odometry(rows, row) : nullptr) {
      const bool both = (*own)["iou"].is_number() && rates["iou"].is_number();
      cells.insert(
          cells.begin() + kAfterIou,
          {rate_text((*own)["iou"]),
           both ? fmt::format("{:+.3f}", (*own)["iou"].get<double>() - rates["iou"].get<double>()) : "-"});
    }
    body.push_back(joined(cells, count_cells(rates)));
  }
  return html_table(head, body, 2) + troubles;
}

std::string stages_table(const Json& figures) {
  std::vector<Cells> body;
  for (const Json& row : main_rows(figures)) {
    for (const Json& stage : row["result"]["stages"])
      body.push_back(joined({row["job"]["recording"]["scene"], stage["after"]}, rate_cells(stage)));
  }
  return html_table(joined({"scene", "after"}, kRateHead), body, 2);
}

std::string sweep_table(const Json& figures) {
  std::vector<Cells> body;
  for (const Json& row : rows_of(figures, "sweep")) {
    const Json& r = row["job"]["recording"];
    body.push_back(
        joined({r["scene"], number_text(r["range_noise_m"]), number_text(row["job"]["threshold_m"])},
               rate_cells(row["result"]["final"])));
  }
  return html_table(joined({"scene", "noise [m]", "threshold [m]"}, kRateHead), body, 1);
}

std::string ablation_tables(const Json& figures) {
  std::string out;
  std::vector<Cells> body;
  std::string scene;
  Json plain;
  const auto flush = [&] {
    if (!body.empty()) {
      out += fmt::format("<h3>{}</h3>\n{}", escaped(scene),
                         html_table(joined({"what"}, joined(kRateHead, {"IoU against the whole"})), body, 1));
    }
    body.clear();
  };
  for (const Json& row : rows_of(figures, "ablation")) {
    const Json& rates = row["result"]["final"];
    if (const std::string name = run_name(row["job"]); name != scene) {
      flush();
      scene = name;
      plain = rates;
    }
    const bool both = plain["iou"].is_number() && rates["iou"].is_number();
    body.push_back(joined(
        joined({row["job"]["name"]}, rate_cells(rates)),
        {both ? fmt::format("{:+.3f}", rates["iou"].get<double>() - plain["iou"].get<double>()) : "-"}));
  }
  flush();
  return out;
}

std::string timing_table(const Json& figures) {
  // One row a sensor: its first.
  std::vector<Json> rows;
  for (const Json& row : rows_of(figures, "table")) {
    bool is_new = row["job"]["poses"] == "true";
    for (const Json& other : rows)
      is_new = is_new && other["job"]["recording"]["sensor"] != row["job"]["recording"]["sensor"];
    if (is_new) rows.push_back(row);
  }
  Cells head = {"step"};
  for (const Json& row : rows) {
    const Json& r = row["job"]["recording"];
    head.push_back(fmt::format("{}, {}, {} thread(s)", r["sensor"].get<std::string>(),
                               r["scene"].get<std::string>(), row["result"]["threads"].get<int>()));
  }
  std::vector<Cells> body;
  if (rows.empty()) return "";
  for (const auto& [step, value] : rows.front()["result"]["timing"].items()) {
    Cells cells = {step};
    for (const Json& row : rows) {
      const Json& ms = row["result"]["timing"][step];
      cells.push_back(
          ms["median_ms"].is_number()
              ? fmt::format("{:.1f} / {:.1f}", ms["median_ms"].get<double>(), ms["p95_ms"].get<double>())
              : "-");
    }
    std::replace(cells.front().begin(), cells.front().end(), '_', ' ');
    body.push_back(std::move(cells));
  }
  return html_table(head, body, 1);
}

}  // namespace mapless::app
