#include "detection/evidence/collect_evidence.hpp"

#include <algorithm>
#include <functional>
#include <span>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/evidence/scanline_sampler.hpp"

namespace mapless::inline v1 {
namespace {

// Rows a thread samples together. More keep the poses and ranges of one reference scan in its cache for
// longer; fewer are shared more evenly among threads. Measured: benchmarks/detection_benchmark.
constexpr std::size_t kMaxRowsAtOnce = 9;

// Every second row and the last one, or the rows between these.
std::vector<ScanlineSampler::Row> rows_of(const LidarScan& scan, bool between) {
  const int last = scan.rows() - 1;
  std::vector<ScanlineSampler::Row> rows;
  rows.reserve(scan.model->lasers.size());
  auto begin = scan.returns.begin();
  for (int l = 0; l <= last; ++l) {
    const auto end =
        std::partition_point(begin, scan.returns.end(), [l](const LidarReturn& r) { return r.laser <= l; });
    if (between == (l % 2 == 1 && l != last)) {
      rows.push_back({static_cast<std::size_t>(begin - scan.returns.begin()),
                      static_cast<std::size_t>(end - scan.returns.begin())});
    }
    begin = end;
  }
  return rows;
}

}  // namespace

std::vector<PointEvidence> collect_evidence(const LidarScan& scan, const LocalPoints& points,
                                            const std::vector<ReferenceScan>& references, const RayImage& own,
                                            const VotingParameters& parameters, ScanExplanation* explanation,
                                            const std::vector<ReferenceScan>& others) {
  const EvidenceCollector collector(scan, points, references, own, parameters, explanation, others);
  if (explanation) explanation->source.assign(points.points.size(), -1);
  std::vector<PointEvidence> evidence(points.points.size());
  tbb::enumerable_thread_specific<ScanlineSampler> of_thread(std::cref(scan), std::cref(points),
                                                             std::cref(collector));
  for (const bool between : {false, true}) {
    const std::vector<ScanlineSampler::Row> rows = rows_of(scan, between);
    const std::size_t parts = (rows.size() + kMaxRowsAtOnce - 1) / kMaxRowsAtOnce;
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
      const std::size_t first = part * rows.size() / parts, end = (part + 1) * rows.size() / parts;
      of_thread.local().sample(std::span(rows).subspan(first, end - first), between, evidence);
    });
  }
  return evidence;
}

}  // namespace mapless
