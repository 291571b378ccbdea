#include "benchmark/paper/paper_page.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "benchmark/page/html.hpp"
#include "benchmark/page/page_parts.hpp"
#include "benchmark/paper/paper_plots.hpp"
#include "reports/json.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

constexpr const char* kOpening = R"(<h1>mapless: the paper's evaluation</h1>
<p>Yoon, Tang, Barfoot, <em>Mapless Online Detection of Dynamic Objects in 3D Lidar</em>, section V, repeated: two
towns, a sensor of 64 x 2000 rays at 10 Hz and 120 m, scans distorted by the sensor's own motion, true poses. The
published method (profile <em>paper</em>) is drawn solid, the default method dashed.</p>
)";

constexpr const char* kPaperSweepText =
    R"(<p>The error threshold is swept from 0.05 to 2 m; every point is a run of
the whole detector over {} scans a town, in stretches spread evenly over the drive. <em>Total</em> rates come from sums
over scans; <em>average</em> rates are means over the scans with a denominator.</p>
)";

constexpr const char* kPaperStagesText =
    R"(<p>The published method after each of its stages, over the same thresholds.
The default method has other stages; its final labels are drawn. The pictures show the stages around the vehicle with
most visible points in the first scans of each town, at the method's own threshold: moving points found green, missed
blue, static ones called dynamic orange.</p>
)";

std::string heading(const std::string& title) { return fmt::format("<h2>{}</h2>\n", title); }

std::string plot_figures(const std::vector<NamedPlot>& plots, std::string_view prefix) {
  std::string out;
  for (const NamedPlot& plot : plots) {
    if (plot.file.starts_with(prefix)) out += plot.plot.figure();
  }
  return "<div class=\"plots\">\n" + out + "</div>\n";
}

Cells paper_rate_cells(const Json& r) {
  return {rate_text(r["precision"]),
          rate_text(r["recall"]),
          rate_text(r["iou"]),
          rate_text(r["average_precision"]),
          rate_text(r["average_recall"]),
          count_text(r["scans"]),
          count_text(r["tp"].get<std::int64_t>() + r["fn"].get<std::int64_t>())};
}

const Cells kPaperHead = {"precision",   "recall", "IoU",          "avg. precision",
                          "avg. recall", "scans",  "moving points"};

std::string every_scan_table(const Json& figures) {
  std::vector<Cells> body;
  for (const Json& row : figures["every_scan"])
    body.push_back(joined({row["town"], row["method"], fmt::format("{}", row["threshold_m"].get<double>())},
                          paper_rate_cells(row["final"])));
  return html_table(joined({"town", "method", "threshold [m]"}, kPaperHead), body, 2);
}

std::string stage_rows(const Json& figures) {
  std::vector<Cells> body;
  for (const Json& row : figures["every_scan"]) {
    for (const Json& stage : row["stages"])
      body.push_back(joined({row["town"], row["method"], stage["after"]}, paper_rate_cells(stage)));
  }
  return html_table(joined({"town", "method", "after"}, kPaperHead), body, 3);
}

std::string whole_sweep_table(const Json& figures) {
  std::vector<Cells> body;
  for (const Json& row : figures["sweep"])
    body.push_back(joined(
        {row["town"], row["method"], row["treatment"], fmt::format("{}", row["range_noise_m"].get<double>()),
         fmt::format("{}", row["threshold_m"].get<double>())},
        paper_rate_cells(row["final"])));
  return "<details><summary>every run of the sweep as a table</summary>\n" +
         html_table(joined({"town", "method", "treatment", "noise [m]", "threshold [m]"}, kPaperHead), body,
                    3) +
         "</details>\n";
}

std::string cascades(const Json& figures, const BenchmarkFolder& folder) {
  std::string out, shown;
  for (const Json& picture : figures["pictures"]) {
    if (picture["kind"] != "cascade") continue;
    const std::string of =
        fmt::format("{}, {}", picture["town"].get<std::string>(), picture["method"].get<std::string>());
    if (of != shown)
      out +=
          (shown.empty() ? "" : "</div>\n") + fmt::format("<h3>{}</h3>\n", of) + "<div class=\"cascade\">\n";
    shown = of;
    const auto caption = picture["caption"].get<std::string>();
    out += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                       inlined_png(folder.pictures() / picture["file"].get<std::string>(), caption),
                       escaped(caption));
  }
  return shown.empty() ? out : out + "</div>\n";
}

std::string stage_times(const Json& figures) {
  Cells head = {"step"};
  for (const Json& row : figures["every_scan"])
    head.push_back(fmt::format("{}, {}", row["town"].get<std::string>(), row["method"].get<std::string>()));
  std::vector<Cells> body;
  for (const auto& [step, ignored] : figures["every_scan"].front()["timing"].items()) {
    Cells cells = {step};
    std::replace(cells.front().begin(), cells.front().end(), '_', ' ');
    for (const Json& row : figures["every_scan"]) {
      const Json& ms = row["timing"][step];
      cells.push_back(
          ms["median_ms"].is_number()
              ? fmt::format("{:.1f} / {:.1f}", ms["median_ms"].get<double>(), ms["p95_ms"].get<double>())
              : "-");
    }
    body.push_back(std::move(cells));
  }
  return html_table(head, body, 1);
}

std::string provenance(const Json& figures) {
  return fmt::format("<p class=\"soft\">mapless {}. {} s of each town, seed {}. {}, {} threads, {}. {}</p>\n",
                     escaped(figures["version"].get<std::string>()), figures["duration_s"].get<double>(),
                     figures["seed"].get<std::uint64_t>(), escaped(figures["processor"].get<std::string>()),
                     figures["threads"].get<std::size_t>(), figures["date"].get<std::string>(),
                     figures["quick"].get<bool>() ? "The quick version." : "");
}

std::int64_t swept_scans(const Json& figures) {
  return figures["sweep"].empty() ? 0 : figures["sweep"].front()["final"]["scans"].get<std::int64_t>();
}

}  // namespace

void write_paper_page(const Json& figures, const BenchmarkFolder& folder) {
  const auto plots = paper_plots(figures);
  for (const NamedPlot& plot : plots) plot.plot.png().write_png(folder.plots() / (plot.file + ".png"));
  std::string body = kOpening + provenance(figures);
  body += heading("Every scan") + every_scan_table(figures);
  body += heading("Precision and recall over the error threshold");
  body += fmt::format(kPaperSweepText, swept_scans(figures)) + plot_figures(plots, "precision_recall_") +
          whole_sweep_table(figures);
  body += heading("After each stage") + kPaperStagesText + plot_figures(plots, "stages_") +
          stage_rows(figures) + cascades(figures, folder);
  body += heading("Recall within a range limit") + plot_figures(plots, "recall_range_");
  body += heading("Without motion compensation, without forward check");
  body += "<p>Not compensated: rays and points have the pose of the middle of the scan.</p>\n" +
          plot_figures(plots, "parts_taken_away_");
  body += heading("Milliseconds a scan");
  body +=
      "<p>Median / 95 % of the scans, median over the units of 300 scans; wall time, other runs side by "
      "side.</p>\n" +
      stage_times(figures);
  write_file_atomically(folder.page(), html_page("mapless: the paper's evaluation", body));
}

std::string paper_text(const Json& figures) {
  std::string out =
      fmt::format("{:<8}{:<9}{:>10}{:>11}{:>8}{:>8}{:>16}{:>13}{:>8}\n", "town", "method", "threshold",
                  "precision", "recall", "IoU", "avg. precision", "avg. recall", "scans");
  for (const Json& row : figures["every_scan"]) {
    const Json& f = row["final"];
    out += fmt::format("{:<8}{:<9}{:>10}{:>11}{:>8}{:>8}{:>16}{:>13}{:>8}\n", row["town"].get<std::string>(),
                       row["method"].get<std::string>(), row["threshold_m"].get<double>(),
                       rate_text(f["precision"]), rate_text(f["recall"]), rate_text(f["iou"]),
                       rate_text(f["average_precision"]), rate_text(f["average_recall"]),
                       f["scans"].get<std::int64_t>());
  }
  return out;
}

}  // namespace mapless::app
