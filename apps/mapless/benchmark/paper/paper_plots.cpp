#include "benchmark/paper/paper_plots.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace mapless::app {
namespace {

constexpr double kStagesNoise_m = 0.02;

const Axis kRecall{"recall"}, kPrecision{"precision"};

std::vector<std::string> towns_of(const Json& figures) {
  std::vector<std::string> towns;
  for (const Json& row : figures["every_scan"]) {
    const auto town = row["town"].get<std::string>();
    if (std::find(towns.begin(), towns.end(), town) == towns.end()) towns.push_back(town);
  }
  return towns;
}

/// Which rows of the sweep a curve is made of.
struct Choice {
  std::string town, method, treatment = "full";
  double noise_m = kStagesNoise_m;

  [[nodiscard]] bool holds(const Json& row) const {
    return row["town"] == town && row["method"] == method && row["treatment"] == treatment &&
           row["range_noise_m"] == noise_m;
  }
};

// Precision over recall of the chosen rows, a point per threshold. `rates` picks the rates of a row.
template <class Rates>
PlotLine curve_of(const Json& figures, const Choice& choice, const Rates& rates, bool average,
                  bool named_points) {
  PlotLine line;
  line.dashed = choice.method == "default";
  for (const Json& row : figures["sweep"]) {
    if (!choice.holds(row)) continue;
    const Json& r = rates(row);
    const Json& x = r[average ? "average_recall" : "recall"];
    const Json& y = r[average ? "average_precision" : "precision"];
    if (!x.is_number() || !y.is_number()) continue;
    line.points.emplace_back(x.get<double>(), y.get<double>());
    if (named_points) line.point_names.push_back(fmt::format("{}", row["threshold_m"].get<double>()));
  }
  return line;
}

const Json& final_of(const Json& row) { return row["final"]; }

Plot noise_plot(const Json& figures, const std::string& town, bool average) {
  Plot plot{fmt::format("{}: {} precision and recall over the error threshold [m]", town,
                        average ? "average" : "total"),
            kRecall,
            kPrecision,
            {}};
  for (const char* method : {"paper", "default"}) {
    std::size_t color = 0;
    for (const double noise_m : {0.0, 0.02, 0.05}) {
      const bool named = noise_m == kStagesNoise_m && std::string_view(method) == "paper";
      PlotLine line = curve_of(figures, {town, method, "full", noise_m}, final_of, average, named);
      line.name = fmt::format("{}, noise {} m", method, noise_m);
      line.color = color++;
      plot.lines.push_back(std::move(line));
    }
  }
  return plot;
}

Plot stages_plot(const Json& figures, const std::string& town) {
  Plot plot{fmt::format("{}: total precision and recall after each stage, noise {} m", town, kStagesNoise_m),
            kRecall,
            kPrecision,
            {}};
  const Choice published{town, "paper"}, ours{town, "default"};
  const auto row = std::find_if(figures["sweep"].begin(), figures["sweep"].end(),
                                [&](const Json& r) { return published.holds(r); });
  if (row == figures["sweep"].end()) return plot;
  for (std::size_t s = 0; s < (*row)["stages"].size(); ++s) {
    const auto stage = [s](const Json& r) -> const Json& { return r["stages"][s]; };
    PlotLine line = curve_of(figures, published, stage, false, false);
    line.name = (*row)["stages"][s]["after"].get<std::string>();
    line.color = s;
    plot.lines.push_back(std::move(line));
  }
  plot.lines.push_back(curve_of(figures, ours, final_of, false, false));
  plot.lines.back().name = "default";
  plot.lines.back().color = plot.lines.size();
  return plot;
}

Plot treatment_plot(const Json& figures, const std::string& town) {
  Plot plot{fmt::format("{}: with parts taken away, total, noise {} m", town, kStagesNoise_m),
            kRecall,
            kPrecision,
            {}};
  for (const char* method : {"paper", "default"}) {
    std::size_t color = 0;
    for (const char* treatment : {"full", "no motion compensation", "no forward check"}) {
      PlotLine line = curve_of(figures, {town, method, treatment}, final_of, false, false);
      const std::string_view what(treatment);
      line.name = fmt::format("{}{}", method,
                              what == "full"                     ? ""
                              : what == "no motion compensation" ? ", not compensated"
                                                                 : ", no forward check");
      line.color = color++;
      plot.lines.push_back(std::move(line));
    }
  }
  return plot;
}

Plot range_plot(const Json& figures, const std::string& town) {
  Plot plot{
      fmt::format("{}: recall of points within a range limit, every scan, noise {} m", town, kStagesNoise_m),
      axis_from_zero("range limit [m]", 120),
      kRecall,
      {}};
  for (const Json& row : figures["every_scan"]) {
    if (row["town"] != town) continue;
    for (const bool average : {false, true}) {
      PlotLine line;
      line.name = fmt::format("{}, {}", row["method"].get<std::string>(), average ? "average" : "total");
      line.dashed = row["method"] == "default";
      line.color = average ? 1 : 0;
      for (const Json& limit : row["within_range"]) {
        const Json& recall = limit[average ? "average_recall" : "recall"];
        if (recall.is_number())
          line.points.emplace_back(limit["limit_m"].get<double>(), recall.get<double>());
      }
      plot.lines.push_back(std::move(line));
    }
  }
  return plot;
}

}  // namespace

std::vector<NamedPlot> paper_plots(const Json& figures) {
  std::vector<NamedPlot> plots;
  for (const std::string& town : towns_of(figures)) {
    plots.push_back({"precision_recall_total_" + town, noise_plot(figures, town, false)});
    plots.push_back({"precision_recall_average_" + town, noise_plot(figures, town, true)});
    plots.push_back({"stages_" + town, stages_plot(figures, town)});
    plots.push_back({"recall_range_" + town, range_plot(figures, town)});
    plots.push_back({"parts_taken_away_" + town, treatment_plot(figures, town)});
  }
  return plots;
}

}  // namespace mapless::app
