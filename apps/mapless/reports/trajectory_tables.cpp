#include "reports/trajectory_tables.hpp"

#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "reports/json.hpp"

namespace mapless::app {
namespace {

std::string row(std::string_view name, std::string_view unit, const ErrorFigures& f) {
  return fmt::format("{:<44}{:<8}{:>9.4f}{:>9.4f}{:>9.4f}{:>9.4f}{:>9.4f}{:>9}\n", name, unit, f.rmse, f.mean,
                     f.median, f.p95, f.max, f.count);
}

std::string rows(std::string_view name, const std::optional<PoseErrors>& errors) {
  if (!errors) return "";
  return row(fmt::format("{}, translation", name), "m", errors->translation_m) +
         row(fmt::format("{}, rotation", name), "deg", errors->rotation_deg);
}

std::string drift_table(const Drift& drift) {
  std::string out = fmt::format("\n{:<22}{:>14}{:>22}{:>10}\n", "drift over [m]", "translation [%]",
                                "rotation [deg/100 m]", "segments");
  for (const DriftOfLength& d : drift.by_length) {
    out += fmt::format("{:<22}{:>14.3f}{:>22.4f}{:>10}\n", d.length_m, d.translation_percent,
                       d.rotation_deg_per_100m, d.segments);
  }
  return out + fmt::format("{:<22}{:>14.3f}{:>22.4f}{:>10}\n", "all", drift.translation_percent,
                           drift.rotation_deg_per_100m, drift.segments);
}

Json to_json(const ErrorFigures& f) {
  return {{"rmse", f.rmse}, {"mean", f.mean}, {"median", f.median},
          {"p95", f.p95},   {"max", f.max},   {"count", f.count}};
}

Json to_json(const PoseErrors& e) {
  return {{"translation_m", to_json(e.translation_m)}, {"rotation_deg", to_json(e.rotation_deg)}};
}

Json to_json(const VelocityError& e) {
  return {{"linear_m_per_s", to_json(e.linear_m_per_s)}, {"angular_deg_per_s", to_json(e.angular_deg_per_s)}};
}

Json to_json(const DisplacementError& e) {
  return {{"distance_m", to_json(e.distance_m)}, {"scans", e.scans}};
}

Json to_json(const Drift& drift) {
  Json by_length = Json::array();
  for (const DriftOfLength& d : drift.by_length) {
    by_length.push_back({{"length_m", d.length_m},
                         {"segments", d.segments},
                         {"translation_percent", d.translation_percent},
                         {"rotation_deg_per_100m", d.rotation_deg_per_100m}});
  }
  return {{"segments", drift.segments},
          {"translation_percent", drift.translation_percent},
          {"rotation_deg_per_100m", drift.rotation_deg_per_100m},
          {"by_length", by_length}};
}

template <class What>
Json to_json(const std::optional<What>& what) {
  return what ? to_json(*what) : Json(nullptr);
}

}  // namespace

std::string trajectory_tables(const TrajectoryReport& r) {
  std::string out = fmt::format(
      "\ntrajectory: {} poses, {:.2f} a scan; {} scans, {} compared; path length {:.1f} m\n", r.rows,
      static_cast<double>(r.rows) / static_cast<double>(r.scans), r.scans, r.poses, r.path_length_m);
  if (r.drift) out += drift_table(*r.drift);
  out += fmt::format("\n{:<44}{:<8}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "error", "unit", "RMSE", "mean",
                     "median", "95 %", "max", "count");
  if (r.absolute_aligned_m) out += row("absolute, aligned as a whole (ATE)", "m", *r.absolute_aligned_m);
  out += rows("absolute, aligned at the first", r.absolute_from_first);
  out += rows("relative, per scan (RPE)", r.relative_per_scan);
  const std::string settled = fmt::format("from scan {} on", kSettledFrom);
  out += rows("relative, " + settled, r.relative_per_scan_settled);
  if (r.velocity) {
    out += row("velocity, linear", "m/s", r.velocity->linear_m_per_s);
    out += row("velocity, angular", "deg/s", r.velocity->angular_deg_per_s);
  }
  const std::string name = fmt::format("static points, {} scans apart", kDisplacementGap);
  if (r.displacement) out += row(name, "m", r.displacement->distance_m);
  if (r.displacement_settled) {
    out += row("static points, " + settled, "m", r.displacement_settled->distance_m);
  }
  return out;
}

Json to_json(const TrajectoryReport& r) {
  return {{"rows", r.rows},
          {"poses", r.poses},
          {"scans", r.scans},
          {"path_length_m", r.path_length_m},
          {"drift", to_json(r.drift)},
          {"absolute_aligned_m", to_json(r.absolute_aligned_m)},
          {"absolute_from_first", to_json(r.absolute_from_first)},
          {"relative_per_scan", to_json(r.relative_per_scan)},
          {"relative_per_scan_settled", to_json(r.relative_per_scan_settled)},
          {"velocity", to_json(r.velocity)},
          {"displacement", to_json(r.displacement)},
          {"displacement_settled", to_json(r.displacement_settled)}};
}

}  // namespace mapless::app
