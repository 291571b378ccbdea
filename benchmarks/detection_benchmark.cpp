#include <array>
#include <memory>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "detection/evidence/collect_evidence.hpp"
#include "detection/published/box_filter.hpp"
#include "detection/published/freespace_check.hpp"
#include "detection/published/pointcloud_comparison.hpp"
#include "detection/published/region_growth.hpp"
#include "detection/segmentation/evidence_growth.hpp"
#include "geometry/nearest_neighbours.hpp"
#include "support/detection/prepared.hpp"
#include "support/detection/run_detector.hpp"
#include "support/local_points.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace {

constexpr int kQuery = 30;  // the sensor turns, three cars cross or meet it

DetectorParameters published_parameters() {
  DetectorParameters parameters;
  parameters.method = DetectionMethod::published;
  parameters.forward_gap = 2;
  return parameters;
}

/// A full-size scan of the street (HDL-64E S2, 64 x 2083 rays), what the five published steps need, and
/// what they say of it.
struct Street {
  test::ToyScene scene = test::toy_street("HDL-64E-S2");
  DetectorParameters parameters = published_parameters();
  PreparedScan query = prepared(kQuery);
  PreparedScan earlier = prepared(kQuery - parameters.scan_gap);
  PreparedScan later = prepared(kQuery + parameters.forward_gap);
  std::vector<std::int32_t> moved;    // dynamic after the comparison
  std::vector<std::int32_t> outside;  // of the backward check
  std::vector<char> dynamic;          // after both checks
  std::vector<char> kept;             // by the box filter

  static const Street& instance() {
    static const Street street;
    return street;
  }

 private:
  Street() {
    const auto comparison = compare_pointclouds(query, earlier, parameters.comparison);
    for (std::size_t i = 0; i < comparison.size(); ++i)
      if (comparison[i] == CandidateVerdict::dynamic) moved.push_back(static_cast<std::int32_t>(i));
    dynamic.assign(comparison.size(), 0);
    mark(moved, check_freespace(query, moved, earlier.compensated, parameters.freespace.backward_threshold_m,
                                parameters.freespace));
    mark(outside, check_freespace(query, outside, later.compensated, parameters.freespace.forward_threshold_m,
                                  parameters.freespace));
    const auto boxes = filter_boxes(query.scan(), dynamic, parameters.box_filter);
    for (const FilterVerdict verdict : boxes) kept.push_back(verdict == FilterVerdict::kept ? 1 : 0);
  }
  [[nodiscard]] PreparedScan prepared(int number) const {
    return test::prepare(test::cast_scan(scene, number).scan, *scene.trajectory, parameters.normals);
  }
  void mark(std::vector<std::int32_t> queries, const std::vector<FreespaceVerdict>& verdicts) {
    outside.clear();
    for (std::size_t k = 0; k < queries.size(); ++k) {
      if (verdicts[k] == FreespaceVerdict::inside) dynamic[static_cast<std::size_t>(queries[k])] = 1;
      if (verdicts[k] == FreespaceVerdict::outside) outside.push_back(queries[k]);
    }
  }
};

/// Runs `stage` with as many threads as the benchmark's argument says, and states the time per ray of the
/// scan and per query.
template <class Stage>
void run(benchmark::State& state, std::size_t queries, const Stage& stage) {
  const auto threads = static_cast<std::size_t>(state.range(0));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  for (auto _ : state) benchmark::DoNotOptimize(stage());
  const auto per = [&](std::size_t n) {
    return benchmark::Counter(static_cast<double>(n),
                              benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  };
  state.counters["per_ray"] = per(Street::instance().query.scan().cells.size());
  state.counters["per_query"] = per(queries);
  state.counters["queries"] = static_cast<double>(queries);
}

std::size_t returns() { return Street::instance().query.scan().returns.size(); }

void compensation(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(), [&] { return compensate(s.query.compensated.scan, *s.scene.trajectory); });
}

void neighbours(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(), [&] { return NearestNeighbours(s.query.compensated.points_0); });
}

void normals(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(),
      [&] { return estimate_normals(s.query.compensated, s.query.neighbours, s.parameters.normals); });
}

void comparison(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(), [&] { return compare_pointclouds(s.query, s.earlier, s.parameters.comparison); });
}

void backward(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, s.moved.size(), [&] {
    return check_freespace(s.query, s.moved, s.earlier.compensated,
                           s.parameters.freespace.backward_threshold_m, s.parameters.freespace);
  });
}

void forward(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, s.moved.size(), [&] {
    return check_freespace(s.query, s.moved, s.later.compensated, s.parameters.freespace.forward_threshold_m,
                           s.parameters.freespace);
  });
}

void box_filter(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(), [&] { return filter_boxes(s.query.scan(), s.dynamic, s.parameters.box_filter); });
}

void region_growth(benchmark::State& state) {
  const Street& s = Street::instance();
  run(state, returns(), [&] { return grow_regions(s.query, s.kept, s.parameters.region_growth); });
}

/// What the default method needs of the same scan, and its results.
struct VotingStreet {
  VotingParameters parameters;
  LocalPoints points = test::local_points(Street::instance().query.compensated);
  std::vector<RayImage> images = cast_images();  // the earlier scans, then the later one
  RayImage own = RayImage(Street::instance().query.compensated);
  std::vector<ReferenceScan> references = reference_scans();
  std::vector<PointEvidence> votes =
      collect_evidence(Street::instance().query.scan(), points, references, own, parameters);
  std::vector<FilterVerdict> seeds =
      filter_evidence(Street::instance().query.scan(), points, votes, parameters);

  static const VotingStreet& instance() {
    static const VotingStreet street;
    return street;
  }

 private:
  static std::vector<RayImage> cast_images() {
    const test::ToyScene& scene = Street::instance().scene;
    std::vector<RayImage> images;
    for (const int gap : kGaps)
      images.emplace_back(compensate(test::cast_scan(scene, kQuery - gap).scan, *scene.trajectory));
    return images;
  }
  [[nodiscard]] std::vector<ReferenceScan> reference_scans() const {
    std::vector<ReferenceScan> all;
    for (std::size_t k = 0; k < images.size(); ++k) all.push_back({&images[k], kGaps[k]});
    return all;
  }
  static constexpr std::array kGaps = {2, 4, 8, 16, 30, -1};
};

void ray_image(benchmark::State& state) {
  run(state, returns(), [&] { return RayImage(Street::instance().query.compensated); });
}

/// One earlier scan queried at every point, on one thread: the cost of a query.
void probe(benchmark::State& state) {
  const VotingStreet& s = VotingStreet::instance();
  const auto& all = Street::instance().query.scan().returns;
  run(state, returns(), [&] {
    const FreespaceProbe probe(s.images.front(), s.points.origin_0, s.parameters);
    int inside = 0;
    float column = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i > 0) column += static_cast<float>(all[i].column - all[i - 1].column);
      inside += probe.verdict(s.points.points[i], column) == FreespaceVerdict::inside ? 1 : 0;
    }
    return inside;
  });
}

void votes(benchmark::State& state) {
  const VotingStreet& s = VotingStreet::instance();
  run(state, returns(), [&] {
    return collect_evidence(Street::instance().query.scan(), s.points, s.references, s.own, s.parameters);
  });
}

void vote_filter(benchmark::State& state) {
  const VotingStreet& s = VotingStreet::instance();
  run(state, returns(),
      [&] { return filter_evidence(Street::instance().query.scan(), s.points, s.votes, s.parameters); });
}

void evidence_growth(benchmark::State& state) {
  const VotingStreet& s = VotingStreet::instance();
  run(state, returns(), [&] {
    return grow_evidence(Street::instance().query.scan(), s.points, s.votes, s.seeds, s.parameters);
  });
}

/// One scan into a detector that has all reference scans it can use, or the 30 scans there are.
void run_detector(benchmark::State& state, const DetectorParameters& parameters) {
  const Street& s = Street::instance();
  const int history = kQuery + parameters.forward_gap;
  const auto scans = test::scans_of(test::cast_scans(s.scene, 0, history + 1));
  const auto threads = static_cast<std::size_t>(state.range(0));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  for (auto _ : state) {
    state.PauseTiming();
    auto filled = std::make_unique<Detector>(parameters);
    for (int i = 0; i < history; ++i)
      benchmark::DoNotOptimize(filled->process(scans[static_cast<std::size_t>(i)], *s.scene.trajectory));
    state.ResumeTiming();
    benchmark::DoNotOptimize(filled->process(scans.back(), *s.scene.trajectory));
    state.PauseTiming();
    filled.reset();
    state.ResumeTiming();
  }
  state.counters["per_ray"] =
      benchmark::Counter(static_cast<double>(scans.back()->cells.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void detector(benchmark::State& state) { run_detector(state, {}); }
void published_detector(benchmark::State& state) { run_detector(state, published_parameters()); }

#define MAPLESS_BENCHMARK(stage) \
  BENCHMARK(stage)->Arg(1)->Arg(4)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond)
MAPLESS_BENCHMARK(compensation);
MAPLESS_BENCHMARK(neighbours);
MAPLESS_BENCHMARK(normals);
MAPLESS_BENCHMARK(comparison);
MAPLESS_BENCHMARK(backward);
MAPLESS_BENCHMARK(forward);
MAPLESS_BENCHMARK(box_filter);
MAPLESS_BENCHMARK(region_growth);
MAPLESS_BENCHMARK(ray_image);
BENCHMARK(probe)->Arg(1)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond);
MAPLESS_BENCHMARK(votes);
MAPLESS_BENCHMARK(vote_filter);
MAPLESS_BENCHMARK(evidence_growth);
MAPLESS_BENCHMARK(detector)->Iterations(3);
MAPLESS_BENCHMARK(published_detector)->Iterations(3);

}  // namespace
}  // namespace mapless
