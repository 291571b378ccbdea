#include "reports/evaluation_tables.hpp"

#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace mapless::app {
namespace {

std::string counts_head(std::string_view name) {
  return fmt::format("\n{:<22}{:>10}{:>8}{:>8}{:>8}{:>10}{:>10}{:>10}", name, "precision", "recall", "F1",
                     "IoU", "TP", "FP", "FN");
}

std::string counts_row(std::string_view name, const Counts& c) {
  return fmt::format("{:<22}{:>10}{:>8}{:>8}{:>8}{:>10}{:>10}{:>10}", name, rate_text(c.precision()),
                     rate_text(c.recall()), rate_text(c.f1()), rate_text(c.iou()), c.tp, c.fp, c.fn);
}

std::string found_columns(const Found& found) {
  return fmt::format("{:>9}{:>8}", rate_text(found.share()), found.of);
}

// Whole numbers in (above, up_to] are above + 1 to up_to.
template <class What>
std::string band_name(const Band<What>& band, bool whole) {
  const double first = whole ? band.above + 1 : band.above;
  return std::isfinite(band.up_to) ? fmt::format("{} - {}", first, band.up_to) : fmt::format("{} -", first);
}

std::string range_table(const EvaluationReport& report) {
  std::string out = counts_head("range [m]") + "\n";
  for (const Band<Counts>& band : report.by_range) {
    if (band.counts.points() > band.counts.tn) out += counts_row(band_name(band, false), band.counts) + "\n";
  }
  return out;
}

std::string class_table(const EvaluationReport& report) {
  if (report.by_class.empty()) return "";
  std::string out = counts_head("class") + fmt::format("{:>9}{:>8}", "objects", "of");
  if (report.evident_movers) out += fmt::format("{:>9}{:>8}", "evident", "of");
  out += "\n";
  for (const ClassReport& c : report.by_class) {
    out += counts_row(c.object_class, c.points) + found_columns(c.objects);
    if (c.evident_movers) out += found_columns(*c.evident_movers);
    out += "\n";
  }
  return out;
}

std::string recall_table(std::string_view name, const std::vector<Band<Found>>& bands, bool whole) {
  std::string rows;
  for (const Band<Found>& band : bands) {
    if (band.counts.of == 0) continue;
    rows += fmt::format("{:<22}{:>10}{:>10}\n", band_name(band, whole), rate_text(band.counts.share()),
                        band.counts.of);
  }
  return rows.empty() ? "" : fmt::format("\n{:<22}{:>10}{:>10}\n", name, "recall", "of") + rows;
}

std::string objects_text(const EvaluationReport& report) {
  std::string out = "\n";
  if (report.objects.of > 0) {
    out += fmt::format(
        "objects found (at least half of their moving points): {} of {}, each scan counted by itself\n",
        rate_text(report.objects.share()), report.objects.of);
  }
  if (report.evident_movers) {
    out += fmt::format("evident movers found (above {} m/s, {} points or more, within {} m): {} of {}\n",
                       kEvidentSpeed_mps, kEvidentPoints, kEvidentRange_m,
                       rate_text(report.evident_movers->share()), report.evident_movers->of);
  }
  const FalseObjects& f = report.false_objects;
  out += fmt::format("false objects (most of their points static): {} a scan; {} of {} in {} scans\n",
                     rate_text(f.per_scan()), f.false_ones, f.objects, f.scans);
  return out;
}

}  // namespace

std::string rate_text(const std::optional<double>& rate) { return rate ? fmt::format("{:.3f}", *rate) : "-"; }

std::string report_tables(const EvaluationReport& report) {
  return range_table(report) + class_table(report) +
         recall_table("true speed [m/s]", report.by_speed, false) +
         recall_table("visible points", report.by_visible_points, true) + objects_text(report);
}

std::string hard_case_lines(const SightReport& sight, const std::optional<DelayReport>& delays) {
  std::string out;
  const auto recall = [&out](std::string_view name, const Found& found) {
    if (found.of == 0) return;
    out += fmt::format("{}: recall {} of {} dynamic points\n", name, rate_text(found.share()), found.of);
  };
  const auto delay = [&out](std::string_view name, const Delays& d) {
    if (d.events == 0) return;
    const auto scans = [](const std::optional<double>& s) { return s ? fmt::format("{}", *s) : "-"; };
    out += fmt::format("{}: {} (median) and {} scans (90 %); {} of {} never\n", name, scans(d.median_scans),
                       scans(d.p90_scans), d.never, d.events);
  };
  recall("seen through a fence or another gap", sight.through_gap);
  recall("with only sky behind", sight.before_sky);
  if (delays) {
    delay("delay from start to half of the points dynamic", delays->start);
    delay("delay from stop to under a tenth of them dynamic", delays->stop);
  }
  return out.empty() ? out : "\n" + out;
}

std::string velocity_lines(const VelocityReport& r) {
  std::string out = fmt::format(
      "\nvelocity of found movers (above {} m/s): RMS error {} m/s, median {}, share below {} m/s {}\n"
      "  over {} detections of movers; left out: {} in the first scan of their object, {} of mixed objects\n",
      kMinEvaluatedSpeed_mps, rate_text(r.rms_mps), rate_text(r.median_mps), kSmallVelocityError_mps,
      rate_text(r.small_error_share), r.evaluated, r.first_seen, r.mixed);
  out += fmt::format(
      "  of the {} with standard deviations below {} m/s: RMS error {} m/s; error over standard deviation {} "
      "(RMS of all)\n",
      r.confident, kConfidentVelocityStd_mps, rate_text(r.confident_rms_mps), rate_text(r.normalised_rms));
  const double changes =
      r.movers == 0 ? 0 : static_cast<double>(r.id_changes) / static_cast<double>(r.movers);
  out += fmt::format("changes of id: {} of {} movers found, {:.2f} each\n", r.id_changes, r.movers, changes);
  return out;
}

}  // namespace mapless::app
