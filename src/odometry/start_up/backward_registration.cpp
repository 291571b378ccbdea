#include "odometry/start_up/backward_registration.hpp"

#include <algorithm>

#include "odometry/map/points_in_world.hpp"

namespace mapless::inline v1 {
namespace {

// Scans at the end whose motion is taken as it is: their points are the first map. Measured: with three,
// starts at 10 Hz err alike, VLP-16 flights at 5 Hz by .16 for .13 m over four scans.
constexpr std::size_t kKeptScans = 2;
// Standard deviations of the velocity at the start of these. Measured: with a third of them starts err alike.
constexpr double kKeptSpeedSigma_mps = 0.3;
constexpr double kKeptTurnRateSigma_radps = 0.3;
// Of the pose there: far below any residual, as in origin_prior().
constexpr double kKeptPoseSigma = 1e-5;  // [m], [rad]

TrajectoryKnot reversed(const TrajectoryKnot& knot) {
  return {Time::from_nanoseconds(-knot.time.nanoseconds()), knot.T_v0, -knot.varpi};
}

WindowPrior prior_at(const TrajectoryKnot& knot) {
  Vector12d sigma;
  sigma << Vector6d::Constant(kKeptPoseSigma), Eigen::Vector3d::Constant(kKeptSpeedSigma_mps),
      Eigen::Vector3d::Constant(kKeptTurnRateSigma_radps);
  return prior_of(knot, sigma.cwiseInverse().cwiseAbs2().asDiagonal());
}

void insert(const UsableScan& scan, const std::vector<TrajectoryKnot>& knots, PlaneMap& map) {
  (void)map.insert(points_in_world(scan.points, scan.start, knots[scan.interval], knots[scan.interval + 1]));
}

// Moves the world frame so that the first knot has this pose.
void move_first_to(const SE3& T_v0, std::vector<TrajectoryKnot>& knots) {
  const SE3 shift = knots.front().T_v0.inverse() * T_v0;
  for (TrajectoryKnot& knot : knots) knot.T_v0 = (knot.T_v0 * shift).normalized();
}

}  // namespace

std::optional<std::vector<TrajectoryKnot>> follow_backwards(const std::vector<TrajectoryKnot>& knots,
                                                            const std::vector<UsableScan>& scans,
                                                            RegistrationSettings settings) {
  settings.measurements = nullptr;  // their times are not reversed; the joint registration uses them
  std::vector<TrajectoryKnot> out = knots;
  std::size_t next = scans.size() - kKeptScans;  // scans from here on are in the map
  MappedTrajectory back(settings.point_sigma_m);
  back.marginalises = true;
  for (std::size_t s = next; s < scans.size(); ++s) insert(scans[s], out, back.map);
  std::size_t k = scans[next].interval;
  back.knots = {reversed(out[k])};
  back.prior = prior_at(back.knots.front());
  while (k-- > 0) {
    back.knots.push_back(predicted(back.knots.back(), reversed(out[k]).time));
    if (next == 0 || scans[next - 1].interval != k) continue;  // scans are missing between these knots
    --next;
    const auto found =
        register_scan(back.window(), back.prior, scans[next].bins.reversed(), back.map, settings);
    if (!found || !is_plausible(found->knots.back(), back.knots.back(), back.last_interval_s()))
      return std::nullopt;
    back.accept(*found);
    std::transform(back.knots.rbegin(), back.knots.rend(), out.begin() + static_cast<std::ptrdiff_t>(k),
                   reversed);
    insert(scans[next], out, back.map);
  }
  move_first_to(knots.front().T_v0, out);
  return out;
}

}  // namespace mapless
