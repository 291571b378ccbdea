#include "detection/object_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include <mapless/lidar/aligned_image.hpp>

namespace mapless {
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
      : scan_(scan), trajectory_(trajectory), columns_(static_cast<std::size_t>(scan.columns)) {}

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
    std::optional<Pose>& pose = columns_[static_cast<std::size_t>(column)];
    if (!pose) {
      const TrajectoryState state = trajectory_.at(scan_.column_time(column));
      pose.emplace(Pose{state.T_v0.inverse(), state.varpi});
    }
    return *pose;
  }

  const LidarScan& scan_;
  const Trajectory& trajectory_;
  std::vector<std::optional<Pose>> columns_;
};

// One neighbour in the image: which way, and how far apart the rays are.
struct Side {
  std::uint8_t number;
  int rows, columns;
};
constexpr std::array<Side, 4> kSides = {{{0, 0, -1}, {1, 0, 1}, {2, -1, 0}, {3, 1, 0}}};

class ViewBuilder {
 public:
  ViewBuilder(const Detection& detection, const Trajectory& trajectory)
      : detection_(detection), scan_(*detection.scan), image_(scan_), poses_(scan_, trajectory) {}

  ObjectView view(std::uint16_t number, const std::vector<std::int32_t>& members) {
    ObjectView out;
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

  void set_points(const std::vector<std::int32_t>& members, ObjectView& out) {
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
  [[nodiscard]] double ring_spacing(const std::vector<std::int32_t>& members) const {
    const LidarReturn& middle = at(members[members.size() / 2]);
    const double step = std::max(scan_.model->elevation_step(middle.laser), column_step());
    return static_cast<double>(middle.range_m) * step;
  }
  [[nodiscard]] double column_step() const { return 2 * std::numbers::pi / scan_.model->columns; }

  void add_edges(const std::vector<std::int32_t>& members, ObjectView& out) {
    std::vector<EdgeSample> all;
    std::size_t outline = 0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      for (const Side& side : kSides) {
        if (!ends(members[m], side)) continue;
        ++outline;
        if (goes_on_behind(members[m], side)) all.push_back(edge(members[m], side, out, m));
      }
    }
    if (outline > 0) out.edge_share = static_cast<double>(all.size()) / static_cast<double>(outline);
    const std::size_t stride = stride_for(all.size(), kMostEdgeSamples);
    for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(stride, 1))
      out.edges.push_back(all[i]);
  }

  // The next ray that side is not the object's.
  [[nodiscard]] bool ends(std::int32_t i, const Side& side) const {
    const int row = at(i).laser + side.rows;
    if (row < 0 || row >= scan_.rows()) return true;
    const int aligned = image_.aligned_column(at(i).laser, at(i).column);
    const std::int32_t cell = scan_.cell(row, image_.scan_column(row, aligned + side.columns));
    return cell < 0 || detection_.object[static_cast<std::size_t>(cell)] !=
                           detection_.object[static_cast<std::size_t>(i)];
  }

  // The next ray that side, and the one after, pass by and go on well behind.
  [[nodiscard]] bool goes_on_behind(std::int32_t i, const Side& side) const {
    const int steps = side.rows == 0 ? 2 : 1;
    for (int s = 1; s <= steps; ++s) {
      const int row = at(i).laser + s * side.rows;
      if (row < 0 || row >= scan_.rows()) return false;
      const int aligned = image_.aligned_column(at(i).laser, at(i).column);
      const int column = image_.scan_column(row, aligned + s * side.columns);
      const std::int32_t cell = scan_.cell(row, column);
      if (cell < 0) {
        if (code_of_cell(cell) != ReturnCode::nothing || !ends_before_reach(at(i))) return false;
      } else if (detection_.object[static_cast<std::size_t>(cell)] ==
                     detection_.object[static_cast<std::size_t>(i)] ||
                 static_cast<double>(at(cell).range_m - at(i).range_m) < kEdgeDepth_m) {
        return false;
      }
    }
    return true;
  }

  // A surface that goes on beyond the sensor's reach has no edge there.
  [[nodiscard]] bool ends_before_reach(const LidarReturn& r) const {
    return static_cast<double>(r.range_m) < kWithinReach * scan_.model->max_range_m;
  }

  EdgeSample edge(std::int32_t i, const Side& side, const ObjectView& view, std::size_t member) {
    const LidarReturn& r = at(i);
    const Matrix3d& C_0v = poses_.C_0v(r.column);
    const Vector3d ray_0 = C_0v * r.position_v.cast<double>().normalized();
    const Vector3d along_columns = C_0v.col(2).cross(ray_0).normalized();
    const LidarModel& model = *scan_.model;
    EdgeSample out;
    out.side = side.number;
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

Scatter scatter_around(const ObjectView& view, const SurfaceSample& sample, std::size_t stride,
                       double radius_m) {
  Scatter out;
  for (std::size_t i = 0; i < view.points_0.size(); i += stride) {
    const Vector3d d = view.points_0[i] - sample.p_0;
    if (d.squaredNorm() > radius_m * radius_m || std::abs(view.t_s[i] - sample.t_s) > kSamePass_s) continue;
    out.sum += d;
    out.squares += d * d.transpose();
    ++out.count;
  }
  return out;
}

// What the neighbourhood of a point looks like. Of a single ring no more shows than that the surface is met
// by the ray, so the part of the ray across the ring is taken for its normal.
void set_shape(const ObjectView& view, const Vector3d& origin_0, std::size_t stride, SurfaceSample& sample) {
  Scatter scatter = scatter_around(view, sample, stride, view.patch_m);
  if (scatter.count < kFewestNeighbours)
    scatter = scatter_around(view, sample, stride, kWidening * view.patch_m);
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

void add_surface(const Vector3d& origin_0, ObjectView& view) {
  const std::size_t stride = stride_for(view.points_0.size(), kMostSurfaceSamples);
  const std::size_t asked = stride_for(view.points_0.size(), kMostNeighboursAsked);
  for (std::size_t i = 0; i < view.points_0.size(); i += stride) {
    SurfaceSample sample;
    sample.p_0 = view.points_0[i];
    sample.t_s = view.t_s[i];
    set_shape(view, origin_0, asked, sample);
    view.surface.push_back(sample);
  }
}

}  // namespace

Eigen::AlignedBox3d ObjectView::box(const Vector3d& velocity_0) const {
  Eigen::AlignedBox3d out;
  for (std::size_t i = 0; i < points_0.size(); ++i) out.extend(points_0[i] - t_s[i] * velocity_0);
  return out;
}

std::vector<ObjectView> object_views(const Detection& detection, const Trajectory& trajectory) {
  std::vector<std::vector<std::int32_t>> members;  // of each number
  for (std::size_t i = 0; i < detection.object.size(); ++i) {
    if (!detection.dynamic(i)) continue;
    const std::size_t number = detection.object[i];
    if (number >= members.size()) members.resize(number + 1);
    members[number].push_back(static_cast<std::int32_t>(i));
  }
  ViewBuilder builder(detection, trajectory);
  std::vector<ObjectView> out;
  for (std::size_t number = 0; number < members.size(); ++number) {
    if (members[number].empty()) continue;
    out.push_back(builder.view(static_cast<std::uint16_t>(number), members[number]));
    const TrajectoryState state = trajectory.at(out.back().time);
    out.back().sight.emplace(detection.scan, state, out.back().time);
    add_surface(state.T_v0.inverse().translation(), out.back());
  }
  return out;
}

}  // namespace mapless
