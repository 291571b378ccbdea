#include "trust/input_check.hpp"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "terminal/stderr.hpp"
#include <mapless/io/dataset.hpp>

namespace mapless::app {

std::vector<std::string> said_doubts(const Dataset& dataset, const std::shared_ptr<const Trajectory>& given,
                                     ScanSelection selection) {
  const std::vector<CheckResult> results = check_recording(dataset, given, selection.first, selection.count);
  require_trusted(results);
  std::vector<std::string> lines;
  for (const CheckResult& r : results) {
    if (r.trust != Trust::doubtful) continue;
    lines.push_back(fmt::format("doubtful {}: {}: {}; {}", r.name, r.where, r.problem, r.remedy));
    say("mapless: {}\n", lines.back());
  }
  return lines;
}

}  // namespace mapless::app
