#include "run/input_output_report.hpp"

#include <vector>

#include <fmt/format.h>

#include "reports/json.hpp"

namespace mapless::app {
namespace {

// Chosen: shorter waits are within the variation from run to run.
constexpr double kLeastReportedShare = 0.1;
constexpr double kLeastReported_s = 1;
// A thread that computes for more than half of its time is not limited by the disk.
constexpr double kComputingShare = 0.5;

double share(double part_s, double run_s) { return run_s > 0 ? part_s / run_s : 0; }

Json side_json(double waited_s, double run_s, const BusyTime& busy) {
  return {{"waited_s", waited_s},
          {"waited_share", share(waited_s, run_s)},
          {"busy_s", busy.wall_s},
          {"processor_s", busy.processor_s}};
}

std::string side_text(const char* what, double waited_s, double run_s, const BusyTime& busy) {
  if (waited_s < kLeastReported_s || share(waited_s, run_s) < kLeastReportedShare) return "";
  const bool computes = busy.processor_s > kComputingShare * busy.wall_s;
  return fmt::format(
      "detection waited {:.1f} s ({:.0f} % of the run) for {}, which took {:.1f} s, {:.1f} s of it {}",
      waited_s, 100 * share(waited_s, run_s), what, busy.wall_s, busy.processor_s,
      computes ? "computing: the disk is not what is slow" : "computing: the disk is slow");
}

}  // namespace

Json to_json(const InputOutputReport& r) {
  return {{"run_s", r.run_s},
          {"reading", side_json(r.waited_for_reading_s, r.run_s, r.reading)},
          {"writing", side_json(r.waited_for_writing_s, r.run_s, r.writing)}};
}

std::string trouble(const InputOutputReport& r) {
  std::vector<std::string> parts;
  for (std::string part : {side_text("reading", r.waited_for_reading_s, r.run_s, r.reading),
                           side_text("writing", r.waited_for_writing_s, r.run_s, r.writing)}) {
    if (!part.empty()) parts.push_back(std::move(part));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace mapless::app
