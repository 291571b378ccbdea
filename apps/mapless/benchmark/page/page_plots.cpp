#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "benchmark/page/page_parts.hpp"

namespace mapless::app {
namespace {

struct Curve {
  double noise_m = 0;
  PlotLine total, average;
};

void add_point(PlotLine& line, const Json& x, const Json& y, const std::string& name = "") {
  if (!x.is_number() || !y.is_number()) return;
  line.points.emplace_back(x.get<double>(), y.get<double>());
  if (!name.empty()) line.point_names.push_back(name);
}

// Curves of one scene, one per noise, in the order of the rows.
std::vector<Curve> curves_of(const std::vector<Json>& rows) {
  std::vector<Curve> curves;
  for (const Json& row : rows) {
    const double noise_m = row["job"]["recording"]["range_noise_m"];
    const double threshold_m = row["job"]["threshold_m"];
    const Json& r = row["result"]["final"];
    if (curves.empty() || curves.back().noise_m != noise_m) curves.push_back({noise_m, {}, {}});
    // Thresholds are written beside a single curve only; beside several they would overlap.
    const std::string name = curves.size() == 1 ? fmt::format("{} m", threshold_m) : "";
    add_point(curves.back().total, r["recall"], r["precision"], name);
    add_point(curves.back().average, r["average_recall"], r["average_precision"]);
  }
  return curves;
}

// From a tick below the least of the values up to 1.
Axis rate_axis(const std::string& name, const std::vector<Curve>& curves, bool x) {
  double least = 0.9;
  for (const Curve& curve : curves) {
    for (const PlotLine* line : {&curve.total, &curve.average}) {
      for (const auto& [px, py] : line->points) least = std::min(least, x ? px : py);
    }
  }
  const double step = least < 0.5 ? 0.2 : 0.1;
  return {name, std::max(0.0, std::floor(least / step - 0.1) * step), 1, step};
}

}  // namespace

std::vector<NamedPlot> threshold_plots(const Json& figures) {
  std::vector<std::string> scenes;
  std::map<std::string, std::vector<Json>> rows;
  for (const Json& row : rows_of(figures, "sweep")) {
    const std::string scene = row["job"]["recording"]["scene"];
    if (!rows.contains(scene)) scenes.push_back(scene);
    rows[scene].push_back(row);
  }
  std::vector<NamedPlot> plots;
  for (const std::string& scene : scenes) {
    auto curves = curves_of(rows[scene]);
    std::stable_sort(curves.begin(), curves.end(),
                     [](const Curve& a, const Curve& b) { return a.noise_m < b.noise_m; });
    Plot plot{fmt::format("{}: precision and recall over the error threshold", scene),
              rate_axis("recall", curves, true),
              rate_axis("precision", curves, false),
              {}};
    for (std::size_t i = 0; i < curves.size(); ++i) {
      for (PlotLine* line : {&curves[i].total, &curves[i].average}) {
        line->dashed = line == &curves[i].average;
        line->name = fmt::format("{}, noise {} m", line->dashed ? "average" : "total", curves[i].noise_m);
        line->color = i;
        plot.lines.push_back(std::move(*line));
      }
    }
    plots.push_back({"precision_recall_" + scene, std::move(plot)});
  }
  return plots;
}

std::vector<NamedPlot> range_plots(const Json& figures) {
  Plot total{
      "Recall of points within a range limit, total", axis_from_zero("range limit [m]", 120), {"recall"}, {}};
  Plot average = total;
  average.title = "Recall of points within a range limit, average over scans";
  const auto rows = main_rows(figures);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    PlotLine of_total, of_average;
    of_total.name = of_average.name = rows[i]["job"]["recording"]["scene"];
    of_total.color = of_average.color = i;
    const Json measures = rows[i]["result"].value("measures", Json::object());
    for (const Json& limit : measures.value("within_range", Json::array())) {
      add_point(of_total, limit["limit_m"], limit["recall"]);
      add_point(of_average, limit["limit_m"], limit["average_recall"]);
    }
    if (!of_total.points.empty()) total.lines.push_back(std::move(of_total));
    if (!of_average.points.empty()) average.lines.push_back(std::move(of_average));
  }
  if (total.lines.empty()) return {};
  return {{"recall_range_total", std::move(total)}, {"recall_range_average", std::move(average)}};
}

}  // namespace mapless::app
