#include "detection/tracking/object_snapshot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include <Eigen/Eigenvalues>

#include "detection/dynamic_returns.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMostNeighboursAsked = 600;
constexpr double kSamePass_s = 0.02;  // neighbours in space on both sides of the seam are of other instants
constexpr double kEdgeDepth_m = 0.5;  // a ray that goes on behind an edge goes on by this much or more
constexpr double kWithinReach = 0.9;  // of the maximum range
constexpr double kEdgeRoughness_m = 0.03;  // of silhouettes, beside the spacing of the rays
constexpr double kThickness_m = 0.1;       // a plane with its noise and curvature
constexpr double kRingWidth_m = 0.06;      // what is narrower shows one ring
constexpr double kLeastAcross = 0.7;       // sine of the angle at which a ray must meet such a ring
constexpr std::size_t kFewestNeighbours = 5;
constexpr double kWidening = 2;  // of a neighbourhood that holds fewer

std::size_t stride_for(std::size_t count, std::size_t most) { return (count + most - 1) / most; }

// The poses of a scan at its columns, asked for as they are needed; within a column the sensor moves to first
// order (geometry/sensor_motion.hpp does the same for whole scans).
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
  std::vector<std::size_t> known_;  // by column: which of the poses
  std::vector<Pose> poses_;
};

// The way to the next ray of a side.
struct Side {
  int rows, columns;
};
constexpr std::array<Side, kImageSides> kSides = {{{0, -1}, {0, 1}, {-1, 0}, {1, 0}}};

class SnapshotBuilder {
 public:
  SnapshotBuilder(const Detection& detection, const Trajectory& trajectory)
      : detection_(detection), scan_(*detection.scan), image_(scan_), poses_(scan_, trajectory) {}

  ObjectSnapshot view(std::uint16_t number, std::span<const std::int32_t> members) {
    ObjectSnapshot out;
    out.number = number;
    set_points(members, out);
    out.patch_m = std::clamp(2.5 * ring_spacing(members), 0.25, 0.8);
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

  // Metres between the rings on it, or the columns where these are wider apart.
  [[nodiscard]] double ring_spacing(std::span<const std::int32_t> members) const {
    const LidarReturn& middle = at(members[members.size() / 2]);
    const double step = std::max(scan_.model->elevation_step(middle.laser), column_step());
    return static_cast<double>(middle.range_m) * step;
  }
  [[nodiscard]] double column_step() const { return 2 * std::numbers::pi / scan_.model->columns; }

  void add_edges(std::span<const std::int32_t> members, ObjectSnapshot& out) {
    const std::size_t outline = find_silhouette(members);
    if (silhouette_.empty()) return;
    out.edge_share = static_cast<double>(silhouette_.size()) / static_cast<double>(outline);
    const std::size_t stride = stride_for(silhouette_.size(), kMostEdgeSamples);
    out.edges.reserve((silhouette_.size() + stride - 1) / stride);
    for (std::size_t side = 0; side < kImageSides; ++side) {
      for (std::size_t i = 0; i < silhouette_.size(); i += stride) {
        const End& end = silhouette_[i];
        if (end.side == side) out.edges.push_back(edge(members[end.member], kSides[side], out, end.member));
      }
      out.edges_begin[side + 1] = out.edges.size();
    }
  }

  // Of the ends of an object in the image, whose number it returns, those behind which rays go on.
  std::size_t find_silhouette(std::span<const std::int32_t> members) {
    silhouette_.clear();
    std::size_t outline = 0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const LidarReturn& r = at(members[m]);
      const std::uint16_t number = detection_.object[static_cast<std::size_t>(members[m])];
      const int aligned = image_.aligned_column(r.laser, r.column);
      for (std::size_t side = 0; side < kImageSides; ++side) {
        if (goes_on(beside(r.laser, aligned, kSides[side], 1), number)) continue;
        ++outline;
        if (goes_on_behind(r, number, aligned, kSides[side])) silhouette_.push_back({m, side});
      }
    }
    return outline;
  }

  // The cell so many steps to a side; outside the image nothing is known.
  [[nodiscard]] std::int32_t beside(int laser, int aligned, const Side& side, int steps) const {
    const int row = laser + steps * side.rows;
    if (row < 0 || row >= scan_.rows()) return empty_cell(ReturnCode::absent);
    return scan_.cell(row, image_.scan_column(row, aligned + steps * side.columns));
  }
  [[nodiscard]] bool goes_on(std::int32_t cell, std::uint16_t number) const {
    return cell >= 0 && detection_.object[static_cast<std::size_t>(cell)] == number;
  }

  // The next ray that side, and the one after, pass by and go on well behind.
  [[nodiscard]] bool goes_on_behind(const LidarReturn& r, std::uint16_t number, int aligned,
                                    const Side& side) const {
    const int most = side.rows == 0 ? 2 : 1;
    for (int steps = 1; steps <= most; ++steps) {
      const std::int32_t cell = beside(r.laser, aligned, side, steps);
      if (cell < 0) {
        if (code_of_cell(cell) != ReturnCode::nothing || !ends_before_reach(r)) return false;
      } else if (goes_on(cell, number) || static_cast<double>(at(cell).range_m - r.range_m) < kEdgeDepth_m) {
        return false;
      }
    }
    return true;
  }

  // A surface that goes on beyond the sensor's reach has no edge there.
  [[nodiscard]] bool ends_before_reach(const LidarReturn& r) const {
    return static_cast<double>(r.range_m) < kWithinReach * scan_.model->max_range_m;
  }

  EdgeSample edge(std::int32_t i, const Side& side, const ObjectSnapshot& view, std::size_t member) {
    const LidarReturn& r = at(i);
    const Matrix3d& C_0v = poses_.C_0v(r.column);
    const Vector3d ray_0 = C_0v * r.position_v.cast<double>().normalized();
    const Vector3d along_columns = C_0v.col(2).cross(ray_0).normalized();
    const LidarModel& model = *scan_.model;
    EdgeSample out;
    out.t_s = view.t_s[member];
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
    out.p_0 = view.points_0[member] + spacing / 2 * out.across_0;
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
  std::vector<End> silhouette_;  // of the view at work
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

// Points of a view among which the neighbours of its samples are sought, close together in memory.
struct Neighbour {
  Vector3d p_0;
  double t_s;
};

Scatter scatter_around(const std::vector<Neighbour>& asked, const SurfaceSample& sample, double radius_m) {
  Scatter out;
  for (const Neighbour& n : asked) {
    const Vector3d d = n.p_0 - sample.p_0;
    if (d.squaredNorm() > radius_m * radius_m || std::abs(n.t_s - sample.t_s) > kSamePass_s) continue;
    out.sum += d;
    out.squares += d * d.transpose();
    ++out.count;
  }
  return out;
}

// What the neighbourhood of a point looks like. Of a single ring no more shows than that the surface is met
// by the ray, so the part of the ray across the ring is taken for its normal.
void set_shape(const std::vector<Neighbour>& asked, double patch_m, const Vector3d& origin_0,
               SurfaceSample& sample) {
  Scatter scatter = scatter_around(asked, sample, patch_m);
  if (scatter.count < kFewestNeighbours) scatter = scatter_around(asked, sample, kWidening * patch_m);
  if (scatter.count < kFewestNeighbours) return;
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(scatter.covariance());
  const Vector3d spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  if (spread.y() < kRingWidth_m) {
    const Vector3d along = solver.eigenvectors().col(2);
    const Vector3d ray = (sample.p_0 - origin_0).normalized();
    const Vector3d across = ray - ray.dot(along) * along;
    if (spread.z() < kRingWidth_m || across.norm() < kLeastAcross) return;
    sample.normal_0 = across.normalized();
  } else if (spread.x() < kThickness_m && spread.x() < 0.5 * spread.y()) {
    sample.normal_0 = solver.eigenvectors().col(0);
  }
}

void add_surface(const Vector3d& origin_0, std::vector<Neighbour>& asked, ObjectSnapshot& view) {
  const std::size_t count = view.points_0.size();
  asked.clear();
  for (std::size_t i = 0; i < count; i += stride_for(count, kMostNeighboursAsked))
    asked.push_back({view.points_0[i], view.t_s[i]});
  const std::size_t stride = stride_for(count, kMostSurfaceSamples);
  view.surface.reserve((count + stride - 1) / stride);
  for (std::size_t i = 0; i < count; i += stride) {
    SurfaceSample& sample = view.surface.emplace_back();
    sample.p_0 = view.points_0[i];
    sample.t_s = view.t_s[i];
    set_shape(asked, view.patch_m, origin_0, sample);
  }
}

// The points of each object of a scan, in their order.
class Members {
 public:
  explicit Members(const Detection& detection) {
    std::vector<std::int32_t> moving;
    for_each_dynamic(detection.object,
                     [&](std::size_t i) { moving.push_back(static_cast<std::int32_t>(i)); });
    const auto number = [&](std::int32_t i) -> std::size_t {
      return detection.object[static_cast<std::size_t>(i)];
    };
    for (const std::int32_t i : moving) {
      if (number(i) + 2 > begins_.size()) begins_.resize(number(i) + 2, 0);
      ++begins_[number(i) + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    members_.resize(moving.size());
    std::vector<std::size_t> next = begins_;
    for (const std::int32_t i : moving) members_[next[number(i)]++] = i;
  }
  [[nodiscard]] std::size_t numbers() const { return begins_.empty() ? 0 : begins_.size() - 1; }
  [[nodiscard]] std::span<const std::int32_t> of(std::size_t number) const {
    return {members_.begin() + static_cast<std::ptrdiff_t>(begins_[number]),
            begins_[number + 1] - begins_[number]};
  }

 private:
  std::vector<std::int32_t> members_;  // by number
  std::vector<std::size_t> begins_;    // of each number among them, and the end
};

}  // namespace

Eigen::AlignedBox3d ObjectSnapshot::box(const Vector3d& velocity_0) const {
  Eigen::AlignedBox3d out;
  for (std::size_t i = 0; i < points_0.size(); ++i) out.extend(points_0[i] - t_s[i] * velocity_0);
  return out;
}

std::vector<ObjectSnapshot> take_snapshots(const Detection& detection, const Trajectory& trajectory) {
  const Members members(detection);
  SnapshotBuilder builder(detection, trajectory);
  std::vector<Neighbour> asked;
  std::vector<ObjectSnapshot> out;
  out.reserve(members.numbers());
  for (std::size_t number = 0; number < members.numbers(); ++number) {
    if (members.of(number).empty()) continue;
    ObjectSnapshot& view =
        out.emplace_back(builder.view(static_cast<std::uint16_t>(number), members.of(number)));
    const TrajectoryState state = trajectory.at(view.time);
    view.sight.emplace(detection.scan, state, view.time);
    add_surface(state.T_v0.inverse().translation(), asked, view);
  }
  return out;
}

}  // namespace mapless
