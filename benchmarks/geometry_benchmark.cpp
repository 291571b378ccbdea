#include <cmath>
#include <numbers>
#include <optional>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "geometry/nearest_neighbours.hpp"
#include "support/cast_rays.hpp"
#include <mapless/geometry/compensated_scan.hpp>

// Each piece of the geometry room over a full scan: 64 lasers, 2,000 columns, about 128,000 points of a
// street, the sensor driving and turning. Single threads, so that the numbers add up; "per_point" is time per
// return.

namespace mapless {
namespace {

constexpr int kLasers = 64;
constexpr int kColumns = 2000;

// Ground, house fronts 9 m to the left and 12 m to the right with a recess every 8 m, closed 60 m ahead and
// behind.
std::optional<double> street(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double range = 120;
  const auto meet = [&](int axis, double at) {
    const double r = (at - origin[axis]) / direction[axis];
    if (r > 0.5 && r < range) range = r;
    return origin + r * direction;
  };
  meet(2, -1.73);
  meet(0, 60);
  meet(0, -60);
  for (const double side : {9.0, -12.0}) {
    const double x = meet(1, side + std::copysign(1.0, side)).x();
    if (std::sin(2 * std::numbers::pi * x / 8) > -0.5) meet(1, side);
  }
  return range < 120 ? std::optional(range) : std::nullopt;
}

// Drives at 10 m/s while turning at 20 degrees per second, along Gaussian-process knots a scan apart.
GaussianProcessTrajectory driving() {
  const Vector6d varpi = (Vector6d() << -10, 0, 0, 0, 0, -20 * std::numbers::pi / 180).finished();
  std::vector<TrajectoryKnot> knots;
  for (int k = 0; k <= 10; ++k) {
    knots.push_back({Time::from_seconds(0.1 * k), SE3::exp(0.1 * k * varpi), varpi});
  }
  return {std::move(knots), "benchmark"};
}

struct Scene {
  GaussianProcessTrajectory trajectory = driving();
  std::shared_ptr<const LidarScan> scan = cast(0.0);
  CompensatedScan compensated = compensate(scan, trajectory);
  NearestNeighbours neighbours{compensated.points_0};
  CompensatedScan later = compensate(cast(0.4), trajectory);

  [[nodiscard]] std::shared_ptr<const LidarScan> cast(double start_s) const {
    return std::make_shared<LidarScan>(test::cast_rays(test::awkward_model(kLasers, kColumns),
                                                       Time::from_seconds(start_s), trajectory, street));
  }
};

const Scene& scene() {
  static const Scene the_scene;
  return the_scene;
}

void count_points(benchmark::State& state, std::size_t points) {
  state.counters["points"] = static_cast<double>(points);
  state.counters["per_point"] =
      benchmark::Counter(static_cast<double>(points),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void BM_Compensate(benchmark::State& state) {
  const Scene& s = scene();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  for (auto _ : state) benchmark::DoNotOptimize(compensate(s.scan, s.trajectory));
  count_points(state, s.scan->returns.size());
}
BENCHMARK(BM_Compensate)->Unit(benchmark::kMillisecond);

void BM_RestoreMeasuredRays(benchmark::State& state) {
  const Scene& s = scene();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  LidarScan compensated = *s.scan;
  compensated.compensated_to = compensated.column_time(kColumns / 2);
  compensated.time_source = state.range(0) == 0 ? Provenance::sensor : Provenance::recovered_from_angle;
  for (auto _ : state) benchmark::DoNotOptimize(restore_measured_rays(compensated, s.trajectory));
  count_points(state, s.scan->returns.size());
}
BENCHMARK(BM_RestoreMeasuredRays)
    ->ArgName("times_from_angles")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);

void BM_BuildTree(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) benchmark::DoNotOptimize(NearestNeighbours(s.compensated.points_0));
  count_points(state, s.compensated.points_0.size());
}
BENCHMARK(BM_BuildTree)->Unit(benchmark::kMillisecond);

// The pointcloud comparison's question: the nearest point of a scan 0.4 s earlier, in firing order.
void BM_Nearest(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) {
    for (const Eigen::Vector3d& q : s.later.points_0) benchmark::DoNotOptimize(s.neighbours.nearest(q));
  }
  count_points(state, s.later.points_0.size());
}
BENCHMARK(BM_Nearest)->Unit(benchmark::kMillisecond);

void BM_TenNearest(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) {
    for (const Eigen::Vector3d& q : s.later.points_0) benchmark::DoNotOptimize(s.neighbours.nearest(q, 10));
  }
  count_points(state, s.later.points_0.size());
}
BENCHMARK(BM_TenNearest)->Unit(benchmark::kMillisecond);

void BM_Within(benchmark::State& state) {
  const Scene& s = scene();
  std::vector<std::int32_t> found;
  for (auto _ : state) {
    for (const Eigen::Vector3d& q : s.compensated.points_0) {
      s.neighbours.within(q, 0.3, found);
      benchmark::DoNotOptimize(found.data());
    }
  }
  count_points(state, s.compensated.points_0.size());
}
BENCHMARK(BM_Within)->Unit(benchmark::kMillisecond);

void BM_EstimateNormals(benchmark::State& state) {
  const Scene& s = scene();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  NormalParameters parameters;
  parameters.method = static_cast<NormalMethod>(state.range(0));
  state.SetLabel(std::string(kNormalMethodNames.at(static_cast<std::size_t>(state.range(0)))));
  for (auto _ : state) benchmark::DoNotOptimize(estimate_normals(s.compensated, s.neighbours, parameters));
  count_points(state, s.compensated.points_0.size());
}
BENCHMARK(BM_EstimateNormals)->ArgName("method")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mapless
