#include "benchmark/paper/paper_plan.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "benchmark/recording_store.hpp"
#include "reports/json.hpp"
#include <mapless/core/parameters.hpp>

namespace mapless::app {
namespace {

constexpr std::array<std::string_view, 2> kPaperTowns = {"town1", "town2"};
constexpr std::array<double, 3> kPaperNoises_m = {0, 0.02, 0.05};
constexpr double kEveryScanNoise_m = 0.02;
constexpr double kPaperDuration_s = 300, kQuickPaperDuration_s = 20;
constexpr std::array<double, 9> kSwept_m = {0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1, 1.5, 2};
// Of the runs without motion compensation and without forward check: enough for the shape of a curve.
constexpr std::array<double, 5> kAblated_m = {0.1, 0.2, 0.5, 1, 2};
// A fifth to a tenth of the scans, spread evenly over the drive, carries the curves: they need 47 runs a
// scan.
constexpr std::size_t kSweepScans = 20, kSweepPeriod = 200, kQuickSweepPeriod = 100;
// Scans of a unit of the part every_scan: a minute or two of work.
constexpr std::size_t kEveryScanUnit = 300;
// Scans before the first one evaluated. The published method compares with the scan four before. The
// reference scans of the default method reach 64 scans back: all of them where every scan is evaluated, the
// nine nearest in a sweep.
constexpr std::size_t kPublishedLead = 5, kDefaultLead = 64, kDefaultSweepLead = 25;

PaperRun run_of(std::string_view method, std::string_view treatment, std::optional<double> threshold_m,
                std::size_t lead) {
  PaperRun run;
  run.method = method;
  run.treatment = treatment;
  run.parameters = detector_profile(method);
  run.lead = lead;
  run.threshold_m = threshold_m.value_or(run.parameters.comparison.error_threshold_m);
  if (threshold_m) run.parameters = with_error_threshold(run.parameters, *threshold_m);
  if (treatment == "no motion compensation") run.compensation = Compensation::none;
  if (treatment == "no forward check") run.parameters.forward_gap = 0;
  return run;
}

std::vector<PaperRun> sweep_runs(double noise_m) {
  std::vector<PaperRun> runs;
  for (const auto& [method, lead] : {std::pair("paper", kPublishedLead), {"default", kDefaultSweepLead}}) {
    for (const double threshold_m : kSwept_m) runs.push_back(run_of(method, "full", threshold_m, lead));
    if (noise_m != kEveryScanNoise_m) continue;
    for (const char* treatment : {"no motion compensation", "no forward check"}) {
      for (const double threshold_m : kAblated_m)
        runs.push_back(run_of(method, treatment, threshold_m, lead));
    }
  }
  return runs;
}

// The last kSweepScans of every period, so that the detectors have their scans before.
void add_sweep(std::vector<PaperUnit>& units, PaperUnit unit, std::size_t scans, std::size_t period) {
  unit.part = PaperUnit::Part::sweep;
  unit.runs = sweep_runs(unit.recording.range_noise_m);
  unit.count = std::min(kSweepScans, scans);
  for (std::size_t end = std::min(period, scans); end <= scans; end += period) {
    unit.first = end - unit.count;
    units.push_back(unit);
  }
}

void add_every_scan(std::vector<PaperUnit>& units, PaperUnit unit, std::size_t scans) {
  unit.part = PaperUnit::Part::every_scan;
  unit.runs = {run_of("paper", "full", std::nullopt, kPublishedLead),
               run_of("default", "full", std::nullopt, kDefaultLead)};
  for (unit.first = 0; unit.first < scans; unit.first += kEveryScanUnit) {
    unit.count = std::min(kEveryScanUnit, scans - unit.first);
    unit.pictures = unit.first == 0;
    units.push_back(unit);
  }
}

}  // namespace

Json PaperRun::json() const {
  Json settings = Json::object();
  DetectorParameters copy = parameters;
  for (const ParameterReference& p : parameter_references(copy)) settings[p.key] = p.text();
  return {{"method", method},
          {"treatment", treatment},
          {"threshold_m", threshold_m},
          {"lead", lead},
          {"parameters", settings}};
}

std::string PaperUnit::stem() const {
  return fmt::format("{}.{}.{:06}", recording.name(), part == Part::sweep ? "sweep" : "every-scan", first);
}

Json PaperUnit::json() const {
  Json all = Json::array();
  for (const PaperRun& run : runs) all.push_back(run.json());
  return {{"part", part == Part::sweep ? "sweep" : "every scan"},
          {"recording", recording.json()},
          {"columns", columns},
          {"first", first},
          {"count", count},
          {"pictures", pictures},
          {"runs", all}};
}

LidarModel PaperUnit::sensor() const {
  LidarModel model = recording.model();
  model.name = fmt::format("{}x{}", model.name, columns);
  model.columns = columns;
  return model;
}

std::vector<PaperUnit> make_paper_plan(const PaperOptions& options) {
  std::vector<PaperUnit> sweeps, every_scan;
  for (const std::string_view town : kPaperTowns) {
    for (const double noise_m : kPaperNoises_m) {
      PaperUnit unit;
      unit.recording.scene = town;
      unit.recording.sensor = "HDL-64E-S2";
      unit.recording.range_noise_m = noise_m;
      unit.recording.seed = options.seeds.front();
      unit.recording.duration_s =
          options.duration_s.value_or(options.quick ? kQuickPaperDuration_s : kPaperDuration_s);
      const std::size_t scans = RecordingStore::scans(unit.recording);
      add_sweep(sweeps, unit, scans, options.quick ? kQuickSweepPeriod : kSweepPeriod);
      if (noise_m == kEveryScanNoise_m) add_every_scan(every_scan, unit, scans);
    }
  }
  every_scan.insert(every_scan.end(), sweeps.begin(), sweeps.end());
  return every_scan;
}

}  // namespace mapless::app
