#include "benchmark/page/page.hpp"

#include <fmt/format.h>

#include "benchmark/page/html.hpp"
#include "benchmark/page/page_parts.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

std::string section(const std::string& title, const std::string& text, const std::string& body) {
  if (body.empty()) return "";
  return fmt::format("<h2>{}</h2>\n{}{}", title, text, body);
}

std::string plot_figures(const std::vector<NamedPlot>& plots) {
  std::string out;
  for (const NamedPlot& plot : plots) out += plot.plot.figure();
  return out.empty() ? out : "<div class=\"plots\">\n" + out + "</div>\n";
}

std::string folded(const std::string& summary, const std::string& body) {
  return fmt::format("<details><summary>{}</summary>\n{}</details>\n", summary, body);
}

// Of every recording that has one. The browser loads a drive once it is unfolded.
std::string views_html(const Json& figures) {
  std::string out;
  for (const Json& row : rows_of(figures, "table")) {
    const std::string view = escaped(row["result"].value("view", "")), name = escaped(run_name(row["job"]));
    if (view.empty()) continue;
    out += folded(name,
                  fmt::format("<p><a href=\"views/{0}\">in a window of its own</a></p>\n"
                              "<iframe loading=\"lazy\" src=\"views/{0}\" title=\"{1}, in 3D\"></iframe>\n",
                              view, name));
  }
  return out;
}

std::string headline(const Json& figures) {
  const auto rows = main_rows(figures);
  if (rows.empty()) return "";
  const Json& row = rows.front();
  const Json& r = row["result"]["final"];
  const auto fact = [](const std::string& value, const std::string& name) {
    return fmt::format("<div><b>{}</b><span>{}</span></div>\n", value, name);
  };
  const Json& ms = row["result"]["timing"]["total"]["median_ms"];
  return fmt::format(
      "<p class=\"soft\">{}, {} scans:</p>\n<div class=\"facts\">\n{}{}{}{}{}</div>\n",
      escaped(run_name(row["job"])), count_text(r["scans"]), fact(rate_text(r["precision"]), "precision"),
      fact(rate_text(r["recall"]), "recall"), fact(rate_text(r["f1"]), "F1"),
      fact(rate_text(r["iou"]), "IoU of moving points"),
      fact(ms.is_number() ? fmt::format("{:.0f} ms", ms.get<double>()) : "-", "a scan, median"));
}

std::string opening(const Json& figures) {
  std::string settings;
  for (const Json& setting : figures["settings"]) settings += ", " + setting.get<std::string>();
  return fmt::format(
      "<h1>mapless: benchmark</h1>\n"
      "<p>Which points of a spinning lidar are moving now? The scans are simulated with motion distortion:\n"
      "every ray is cast at its own firing time, and every point has a true label. They are labelled scan "
      "by\n"
      "scan, without a map, and compared with the truth point by point.</p>\n"
      "<p class=\"soft\">mapless {}, profile {}{}. {}, {} threads, {}. {}</p>\n",
      escaped(figures["version"].get<std::string>()), escaped(figures["profile"].get<std::string>()),
      escaped(settings), escaped(figures["processor"].get<std::string>()),
      figures["threads"].get<std::size_t>(), figures["date"].get<std::string>(),
      figures["quick"].get<bool>() ? "The quick version: one scene." : "");
}

constexpr const char* kKey =
    "<ul class=\"key\"><li><i style=\"background:#009e73\"></i>moving, found</li>"
    "<li><i style=\"background:#0072b2\"></i>moving, missed</li>"
    "<li><i style=\"background:#d55e00\"></i>static, called dynamic</li>"
    "<li><i style=\"background:#b0b7c1\"></i>static</li></ul>\n";

constexpr const char* kViewText =
    "<p>Scans from the middle of each recording. Play, turn, step, and colour them by truth, object or "
    "height.</p>\n";

constexpr const char* kSweepText =
    R"(<p>The error threshold of the pointcloud comparison is swept, as in the paper.
The thresholds of the freespace check keep their proportion to it. Every point of a curve is one run of the whole
detector over the first {} scans, or over all scans of a shorter recording.</p>
)";

constexpr const char* kAblationText = R"(<p>One part is switched off at a time, on the first {} scans.
<em>Not compensated</em>: points, rays or both are placed as if the sensor stood still during the scan, at its pose in
the middle of the scan.</p>
)";

constexpr const char* kCascadeText =
    R"(<p>The moving vehicle with most visible points in one scan. The second, third and
fourth stage remove static points; the last one completes the object.</p>
)";

constexpr const char* kDefinitions = R"(<ul>
<li>A point is <em>moving</em> in truth if the surface it lies on moves faster than 0.2 m/s at the instant of its
ray.</li>
<li><em>Precision</em> is the ratio of points called dynamic that move, <em>recall</em> the ratio of moving points that
are found, <em>F1</em> their harmonic mean, <em>IoU</em> TP / (TP + FP + FN).</li>
<li><em>Total</em> rates, the default, are computed from sums over all scans. <em>Average</em> rates are means over
the scans whose denominator is not 0; N is the number of these scans.</li>
<li>Every scan counts, including the first ones, which have no earlier scan to compare with.</li>
<li>An <em>object</em> in a scan is found if at least half of its moving points are. An <em>evident mover</em> is faster
than 0.5 m/s with 20 visible points or more within 50 m. A <em>false object</em> is a reported object with
more than half of its points static.</li>
<li><em>Through a fence</em>: on either side, within 1 degree, the same laser has a static return nearer by more than
0.5 m. <em>Only sky behind</em>: on either side, the first ray that does not hit the object hits nothing.</li>
<li><em>Start</em>: from the scan in which an object that stood exceeds 0.2 m/s (and then 0.5) to the first with half of
its points called dynamic. <em>Stop</em>: from the scan in which it falls below 0.1 m/s to the first with under a tenth.
<em>Never</em>: not within 25 scans. Objects of 20 points or more.</li>
<li>Poses are the true ones unless a row names odometry: the figures measure detection alone, as in the paper.</li>
</ul>
)";

std::string body(const Json& figures, const BenchmarkFolder& folder, const std::vector<NamedPlot>& sweeps,
                 const std::vector<NamedPlot>& ranges) {
  const auto stretch = figures["stretch_scans"].get<std::size_t>();
  const auto swept = fmt::format(kSweepText, stretch);
  const auto ablated = fmt::format(kAblationText, stretch);
  std::string out = opening(figures) + headline(figures) + pictures(figures, folder, "scan", 1);
  out += section("In 3D", kViewText, views_html(figures));
  out += section("Results", "", results_table(figures) + folded("after each stage", stages_table(figures)));
  out += section("Precision and recall over the error threshold", swept,
                 sweeps.empty() ? "" : plot_figures(sweeps) + folded("as a table", sweep_table(figures)));
  out += section("Recall within a range limit", "", plot_figures(ranges));
  out += section("One mover, stage by stage", std::string(kCascadeText) + kKey,
                 pictures(figures, folder, "cascade", 1));
  out += section(
      "Movers",
      "<p>Each mover in the scan with most of its visible points, found or missed.</p>\n" + std::string(kKey),
      pictures(figures, folder, "gallery", 8));
  out += section(
      "Results by class, range, speed and object",
      "<p>Summed over the scenes, for the first sensor and the first noise; objects scene by scene.</p>\n",
      measure_tables(figures));
  out += section("Ablations", ablated, ablation_tables(figures));
  out += section("Milliseconds a scan",
                 fmt::format("<p>Median / 95 %, wall time. The runs shared {} threads.</p>\n",
                             figures["threads"].get<std::size_t>()),
                 timing_table(figures));
  return out + section("Definitions", "", kDefinitions);
}

}  // namespace

void write_page(const Json& figures, const BenchmarkFolder& folder) {
  const auto sweeps = threshold_plots(figures);
  const auto ranges = range_plots(figures);
  for (const auto* plots : {&sweeps, &ranges}) {
    for (const NamedPlot& plot : *plots) plot.plot.png().write_png(folder.plots() / (plot.file + ".png"));
  }
  write_file_atomically(folder.page(),
                        html_page("mapless: benchmark", body(figures, folder, sweeps, ranges)));
}

std::string results_text(const Json& figures) {
  std::string out = fmt::format("{:<10}{:<12}{:>6}{:>6}{:>11}{:>8}{:>8}{:>8}{:>8}\n", "scene", "sensor",
                                "noise", "seed", "precision", "recall", "F1", "IoU", "scans");
  for (const Json& row : rows_of(figures, "table")) {
    const Json& r = row["job"]["recording"];
    const Json& f = row["result"]["final"];
    out += fmt::format("{:<10}{:<12}{:>6}{:>6}{:>11}{:>8}{:>8}{:>8}{:>8}{}\n", r["scene"].get<std::string>(),
                       r["sensor"].get<std::string>(), r["range_noise_m"].get<double>(),
                       r["seed"].get<std::uint64_t>(), rate_text(f["precision"]), rate_text(f["recall"]),
                       rate_text(f["f1"]), rate_text(f["iou"]), f["scans"].get<std::int64_t>(),
                       row["job"]["poses"] == "true" ? "" : "  own odometry");
  }
  return out;
}

}  // namespace mapless::app
