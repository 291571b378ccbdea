#include "trust/input_check.hpp"

#include <vector>

#include "terminal/stderr.hpp"
#include <mapless/io/dataset.hpp>

namespace mapless::app {

bool says_doubts(const Dataset& dataset, const std::shared_ptr<const Trajectory>& given,
                 ScanSelection selection) {
  const std::vector<CheckResult> results = check_recording(dataset, given, selection.first, selection.count);
  require_trusted(results);
  bool doubtful = false;
  for (const CheckResult& r : results) {
    if (r.trust != Trust::doubtful) continue;
    doubtful = true;
    say("mapless: doubtful {}: {}: {}; {}\n", r.name, r.where, r.problem, r.remedy);
  }
  return doubtful;
}

}  // namespace mapless::app
