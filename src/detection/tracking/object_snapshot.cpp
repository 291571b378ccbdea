#include "detection/tracking/object_snapshot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "detection/dynamic_returns.hpp"
#include "detection/tracking/object_members.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMaxNeighbours =
    600;  // points searched for neighbours of a sample, for the time it takes
// Largest time between neighbours [s]: beyond it they are on both sides of the seam of the scan, a turn
// apart.
constexpr double kSamePass_s = 0.02;

// A silhouette edge: the next ray ends this much farther. Chosen: about a person's depth; a ray that ends
// nearer may have met the same object.
constexpr double kEdgeDepth_m = 0.5;
// A ray without return passes an object nearer than this share of the maximum range; beyond, the object
// itself may be out of reach.
constexpr double kWithinReach = 0.9;
constexpr double kEdgeRoughness_m =
    0.03;  // of silhouettes, beside the spacing of the rays; chosen: range noise

// Neighbourhoods: kPatchSpacings ring spacings, so that a plane is fitted to several rings, within these
// bounds: the smallest holds some columns near the sensor, the largest is half a car.
constexpr double kPatchSpacings = 2.5;
constexpr double kMinPatch_m = 0.25, kMaxPatch_m = 0.8;
constexpr std::size_t kMinNeighbours = 5;  // a plane has three degrees of freedom
constexpr double kWidening = 2;            // of a neighbourhood that holds fewer

// Shape of a neighbourhood by its standard deviations: a plane, with noise and curvature, is thinner than
// kThickness_m and than kMaxAspect of its narrower side. A neighbourhood narrower than kRingWidth_m is of one
// ring.
constexpr double kThickness_m = 0.1;
constexpr double kMaxAspect = 0.5;
constexpr double kRingWidth_m = 0.06;  // three times the range noise
constexpr double kMinAcross = 0.7;     // sine of the angle, 44 degrees, at which a ray must meet such a ring

std::size_t stride_for(std::size_t count, std::size_t most) { return (count + most - 1) / most; }

// Sensor poses at the columns of a scan, computed when first needed; within a column the motion is of first
// order, as in geometry/sensor_motion.hpp for whole scans.
class ColumnPoses {
 public:
  ColumnPoses(const LidarScan& scan, const Trajectory& trajectory)
      : scan_(scan), trajectory_(trajectory), known_(static_cast<std::size_t>(scan.columns), kUnknown) {
    poses_.reserve(known_.size());
  }

  Vector3d to_world(const LidarReturn& r) {
    const Vector3d p_v = r.position_v.cast<double>();
    const std::int64_t period_ns = scan_.column_period.nanoseconds();
    const std::int64_t dt_ns = r.time_ns - r.column * period_ns;
    if (std::abs(dt_ns) > period_ns) return trajectory_.at(scan_.time_of(r)).T_v0.inverse() * p_v;
    const Pose& pose = at(r.column);
    const Vector3d step = pose.varpi.head<3>() + pose.varpi.tail<3>().cross(p_v);
    return pose.T_0v * (p_v - static_cast<double>(dt_ns) * 1e-9 * step);
  }
  const Matrix3d& C_0v(int column) { return at(column).T_0v.rotation(); }

 private:
  struct Pose {
    SE3 T_0v;
    Vector6d varpi;
  };
  const Pose& at(int column) {
    std::size_t& known = known_[static_cast<std::size_t>(column)];
    if (known == kUnknown) {
      const TrajectoryState state = trajectory_.at(scan_.column_time(column));
      known = poses_.size();
      poses_.push_back({state.T_v0.inverse(), state.varpi});
    }
    return poses_[known];
  }

  static constexpr std::size_t kUnknown = std::numeric_limits<std::size_t>::max();
  const LidarScan& scan_;
  const Trajectory& trajectory_;
  std::vector<std::size_t> known_;  // by column: index of its pose
  std::vector<Pose> poses_;
};

// Step to the next ray on one side.
struct Side {
  int rows, columns;
};
constexpr std::array<Side, kImageSides> kSides = {{{0, -1}, {0, 1}, {-1, 0}, {1, 0}}};

class SnapshotBuilder {
 public:
  SnapshotBuilder(const Detection& detection, const Trajectory& trajectory)
      : detection_(detection), scan_(*detection.scan), image_(scan_), poses_(scan_, trajectory) {}

  ObjectSnapshot take(std::uint16_t number, std::span<const std::int32_t> members) {
    ObjectSnapshot out;
    out.number = number;
    set_points(members, out);
    out.patch_m = std::clamp(kPatchSpacings * ring_spacing(members), kMinPatch_m, kMaxPatch_m);
    add_edges(members, out);
    return out;
  }

 private:
  [[nodiscard]] const LidarReturn& at(std::int32_t i) const {
    return scan_.returns[static_cast<std::size_t>(i)];
  }

  void set_points(std::span<const std::int32_t> members, ObjectSnapshot& out) {
    std::int64_t sum_ns = 0;
    for (const std::int32_t i : members) sum_ns += at(i).time_ns;
    const std::int64_t mean_ns = sum_ns / static_cast<std::int64_t>(members.size());
    out.time = scan_.start + Duration::from_nanoseconds(mean_ns);
    out.points_0.reserve(members.size());
    out.t_s.reserve(members.size());
    for (const std::int32_t i : members) {
      out.points_0.push_back(poses_.to_world(at(i)));
      out.t_s.push_back(static_cast<double>(at(i).time_ns - mean_ns) * 1e-9);
      out.seen_box.extend(out.points_0.back());
      out.mean_0 += out.points_0.back();
    }
    out.mean_0 /= static_cast<double>(members.size());
  }

  // The spacing of its rings [m], or of its columns where these are wider apart.
  [[nodiscard]] double ring_spacing(std::span<const std::int32_t> members) const {
    const LidarReturn& middle = at(members[members.size() / 2]);
    const double step = std::max(scan_.model->elevation_step(middle.laser), column_step());
    return static_cast<double>(middle.range_m) * step;
  }
  [[nodiscard]] double column_step() const { return 2 * std::numbers::pi / scan_.model->columns; }

  void add_edges(std::span<const std::int32_t> members, ObjectSnapshot& out) {
    find_silhouette(members);
    if (silhouette_.empty()) return;
    const std::size_t stride = stride_for(silhouette_.size(), kMaxEdgeSamples);
    out.edges.reserve((silhouette_.size() + stride - 1) / stride);
    for (std::size_t side = 0; side < kImageSides; ++side) {
      for (std::size_t i = 0; i < silhouette_.size(); i += stride) {
        const End& end = silhouette_[i];
        if (end.side == side) out.edges.push_back(edge(members[end.member], kSides[side], out, end.member));
      }
      out.edges_begin[side + 1] = out.edges.size();
    }
  }

  // Finds the silhouette edges of an object.
  void find_silhouette(std::span<const std::int32_t> members) {
    silhouette_.clear();
    for (std::size_t m = 0; m < members.size(); ++m) {
      const LidarReturn& r = at(members[m]);
      const std::uint16_t number = detection_.object[static_cast<std::size_t>(members[m])];
      const int aligned = image_.aligned_column(r.laser, r.column);
      for (std::size_t side = 0; side < kImageSides; ++side) {
        if (belongs(beside(r.laser, aligned, kSides[side], 1), number)) continue;
        if (is_edge(r, number, aligned, kSides[side])) silhouette_.push_back({m, side});
      }
    }
  }

  // The cell `steps` to a side; absent beyond the first and last row.
  [[nodiscard]] std::int32_t beside(int laser, int aligned, const Side& side, int steps) const {
    const int row = laser + steps * side.rows;
    if (row < 0 || row >= scan_.rows()) return empty_cell(ReturnCode::absent);
    return scan_.cell(row, image_.scan_column(row, aligned + steps * side.columns));
  }
  [[nodiscard]] bool belongs(std::int32_t cell, std::uint16_t number) const {
    return cell >= 0 && detection_.object[static_cast<std::size_t>(cell)] == number;
  }

  // Whether the next ray on that side, and in a row the one after it, pass the object and end well behind it.
  [[nodiscard]] bool is_edge(const LidarReturn& r, std::uint16_t number, int aligned,
                             const Side& side) const {
    const int rays = side.rows == 0 ? 2 : 1;
    for (int steps = 1; steps <= rays; ++steps) {
      const std::int32_t cell = beside(r.laser, aligned, side, steps);
      if (cell < 0) {
        if (code_of_cell(cell) != ReturnCode::nothing || !is_within_reach(r)) return false;
      } else if (belongs(cell, number) || static_cast<double>(at(cell).range_m - r.range_m) < kEdgeDepth_m) {
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] bool is_within_reach(const LidarReturn& r) const {
    return static_cast<double>(r.range_m) < kWithinReach * scan_.model->max_range_m;
  }

  EdgeSample edge(std::int32_t i, const Side& side, const ObjectSnapshot& snapshot, std::size_t member) {
    const LidarReturn& r = at(i);
    const Matrix3d& C_0v = poses_.C_0v(r.column);
    const Vector3d ray_0 = C_0v * r.position_v.cast<double>().normalized();
    const Vector3d along_columns = C_0v.col(2).cross(ray_0).normalized();
    const LidarModel& model = *scan_.model;
    EdgeSample out;
    out.t_s = snapshot.t_s[member];
    double step = column_step();
    if (side.rows == 0) {
      out.across_0 = model.sign() * side.columns * along_columns;
    } else {
      out.across_0 = side.rows * ray_0.cross(along_columns);
      const auto row = static_cast<std::size_t>(r.laser);
      const auto next = static_cast<std::size_t>(r.laser + side.rows);
      step = std::abs(model.lasers[next].elevation_rad - model.lasers[row].elevation_rad);
    }
    const double spacing = step * static_cast<double>(r.range_m);
    out.p_0 = snapshot.points_0[member] + spacing / 2 * out.across_0;
    out.std_m = std::hypot(spacing / std::sqrt(12.0), kEdgeRoughness_m);
    return out;
  }

  const Detection& detection_;
  const LidarScan& scan_;
  AlignedImage image_;
  ColumnPoses poses_;
  struct End {
    std::size_t member, side;
  };
  std::vector<End> silhouette_;  // of the object at work
};

struct Scatter {
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  std::size_t count = 0;

  [[nodiscard]] Matrix3d covariance() const {
    const double n = static_cast<double>(count);
    return squares / n - sum * sum.transpose() / (n * n);
  }
};

// A point among which the neighbours of samples are searched.
struct Neighbour {
  Vector3d p_0;
  double t_s;
};

Scatter scatter_around(const std::vector<Neighbour>& candidates, const SurfaceSample& sample,
                       double radius_m) {
  Scatter out;
  for (const Neighbour& n : candidates) {
    const Vector3d d = n.p_0 - sample.p_0;
    if (d.squaredNorm() > radius_m * radius_m || std::abs(n.t_s - sample.t_s) > kSamePass_s) continue;
    out.sum += d;
    out.squares += d * d.transpose();
    ++out.count;
  }
  return out;
}

// Sets the normal of a sample from its neighbourhood. A single ring shows only that the ray met the surface:
// its normal is taken to be the part of the ray perpendicular to the ring.
void set_normal(const std::vector<Neighbour>& candidates, double patch_m, const Vector3d& origin_0,
                SurfaceSample& sample) {
  Scatter scatter = scatter_around(candidates, sample, patch_m);
  if (scatter.count < kMinNeighbours) scatter = scatter_around(candidates, sample, kWidening * patch_m);
  if (scatter.count < kMinNeighbours) return;
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(scatter.covariance());
  const Vector3d spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (spread.y() < kRingWidth_m) {
    const Vector3d along = solver.eigenvectors().col(2);
    const Vector3d ray = (sample.p_0 - origin_0).normalized();
    const Vector3d across = ray - ray.dot(along) * along;
    if (spread.z() < kRingWidth_m || across.norm() < kMinAcross) return;
    sample.normal_0 = across.normalized();
  } else if (spread.x() < kThickness_m && spread.x() < kMaxAspect * spread.y()) {
    sample.normal_0 = solver.eigenvectors().col(0);
  }
}

void add_surface(const Vector3d& origin_0, std::vector<Neighbour>& candidates, ObjectSnapshot& snapshot) {
  const std::size_t count = snapshot.points_0.size();
  candidates.clear();
  for (std::size_t i = 0; i < count; i += stride_for(count, kMaxNeighbours))
    candidates.push_back({snapshot.points_0[i], snapshot.t_s[i]});
  const std::size_t stride = stride_for(count, kMaxSurfaceSamples);
  snapshot.surface.reserve((count + stride - 1) / stride);
  for (std::size_t i = 0; i < count; i += stride) {
    SurfaceSample& sample = snapshot.surface.emplace_back();
    sample.p_0 = snapshot.points_0[i];
    sample.t_s = snapshot.t_s[i];
    set_normal(candidates, snapshot.patch_m, origin_0, sample);
  }
}

}  // namespace

Eigen::AlignedBox3d ObjectSnapshot::box(const Vector3d& velocity_0) const {
  Eigen::AlignedBox3d out;
  for (std::size_t i = 0; i < points_0.size(); ++i) out.extend(points_0[i] - t_s[i] * velocity_0);
  return out;
}

std::vector<ObjectSnapshot> take_snapshots(const Detection& detection, const Trajectory& trajectory,
                                           const std::shared_ptr<const RayImage>& rays) {
  const ObjectMembers members(detection.object);
  SnapshotBuilder builder(detection, trajectory);
  std::vector<Neighbour> candidates;
  std::vector<ObjectSnapshot> out;
  out.reserve(members.numbers());
  for (std::size_t number = 0; number < members.numbers(); ++number) {
    if (members.of(number).empty()) continue;
    ObjectSnapshot& snapshot =
        out.emplace_back(builder.take(static_cast<std::uint16_t>(number), members.of(number)));
    snapshot.rays = rays;
    add_surface(trajectory.at(snapshot.time).T_v0.inverse().translation(), candidates, snapshot);
  }
  return out;
}

}  // namespace mapless
