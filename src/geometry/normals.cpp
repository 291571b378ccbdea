#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "geometry/nearest_neighbours.hpp"
#include "geometry/plane_fit.hpp"
#include "lidar/aligned_image.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {
namespace {

// Normals per parallel task of the k nearest neighbours. Chosen: half of kPointsPerTask of sensor_motion.hpp,
// as a normal takes longer than a point.
constexpr std::size_t kNormalsPerTask = 512;
// Cells side by side that share each instruction: the numbers of a vector that every processor has. Their ten
// moments then fit into its registers.
constexpr int kLanes = 4;
using Floats = float __attribute__((vector_size(4 * kLanes)));

Floats load(const float* first) {
  Floats v;
  std::memcpy(&v, first, sizeof(v));
  return v;
}

// The points of a scan in its aligned image, one plane per coordinate; NaN where there is none. Rows have
// margins into which the columns wrap.
class PointImage {
 public:
  PointImage(const CompensatedScan& scan, const AlignedImage& image, int margin)
      : margin_(margin), stride_(scan.scan->columns + 2 * margin) {
    const LidarScan& s = *scan.scan;
    origin_0_ = scan.column_T_0v.front().translation();
    const auto size = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(s.rows());
    for (auto& plane : planes_) plane.assign(size, std::numeric_limits<float>::quiet_NaN());
    for (int row = 0; row < s.rows(); ++row) {
      for (int a = -margin; a < s.columns + margin; ++a) {
        const std::int32_t cell = s.cell(row, image.scan_column(row, a));
        if (cell < 0) continue;
        const Eigen::Vector3f p = local(scan.points_0[static_cast<std::size_t>(cell)]);
        for (std::size_t k = 0; k < 3; ++k) planes_[k][index(row, a)] = p[static_cast<Eigen::Index>(k)];
      }
    }
  }

  /// Relative to the sensor at the start of the scan: single precision resolves 4 um at 50 m from it.
  [[nodiscard]] Eigen::Vector3f local(const Eigen::Vector3d& p_0) const {
    return (p_0 - origin_0_).cast<float>();
  }
  [[nodiscard]] std::array<const float*, 3> at(int row, int aligned) const {
    const std::size_t i = index(row, aligned);
    return {&planes_[0][i], &planes_[1][i], &planes_[2][i]};
  }

 private:
  [[nodiscard]] std::size_t index(int row, int aligned) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(aligned + margin_);
  }
  int margin_, stride_;
  Eigen::Vector3d origin_0_ = Eigen::Vector3d::Zero();
  std::array<std::vector<float>, 3> planes_;
};

// Moments of the neighbours of kLanes points.
struct LaneMoments {
  Floats count{}, x{}, y{}, z{}, xx{}, xy{}, xz{}, yy{}, yz{}, zz{};

  // Where `near` is not 0; d may be NaN elsewhere.
  template <class Mask>
  void add(const Mask& near, Floats dx, Floats dy, Floats dz) {
    const Floats zero{};
    dx = near ? dx : zero;
    dy = near ? dy : zero;
    dz = near ? dz : zero;
    count += near ? zero + 1 : zero;
    x += dx;
    y += dy;
    z += dz;
    xx += dx * dx;
    xy += dx * dy;
    xz += dx * dz;
    yy += dy * dy;
    yz += dy * dz;
    zz += dz * dz;
  }
  [[nodiscard]] Moments of_lane(int k) const {
    Moments m;
    m.count = count[k];
    m.sum = {x[k], y[k], z[k]};
    m.squares << xx[k], xy[k], xz[k], xy[k], yy[k], yz[k], xz[k], yz[k], zz[k];
    return m;
  }
};

// One element per lane.
struct LanePoints {
  Floats x{}, y{}, z{}, range_m{};
};

class NormalEstimator {
 public:
  NormalEstimator(const CompensatedScan& scan, const NormalParameters& parameters)
      : scan_(scan),
        parameters_(parameters),
        image_(*scan.scan),
        column_rad_(2 * std::numbers::pi / scan.scan->model->columns) {
    const LidarModel& model = *scan.scan->model;
    for (std::size_t c = 0; c < scan.column_T_0v.size(); ++c) {
      const SE3 T_vh(rotation_z(model.hub_angle(static_cast<double>(c))), Eigen::Vector3d::Zero());
      column_T_0h_.push_back(scan.column_T_0v[c] * T_vh);
    }
  }

  [[nodiscard]] std::vector<Eigen::Vector3f> in_space(const NearestNeighbours& neighbours) const {
    std::vector<Eigen::Vector3f> normals(scan_.points_0.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, normals.size(), kNormalsPerTask),
                      [&](const auto& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          normals[i] = normal(i, nearest_in_space(i, neighbours));
                      });
    return normals;
  }

  [[nodiscard]] std::vector<Eigen::Vector3f> in_image() const {
    std::vector<Eigen::Vector3f> normals(scan_.points_0.size());
    if (normals.empty()) return normals;
    std::vector<int> half_columns;
    for (int l = 0; l < scan_.scan->rows(); ++l) half_columns.push_back(half_width(l));
    const int margin = *std::max_element(half_columns.begin(), half_columns.end()) + kLanes;
    const PointImage points(scan_, image_, margin);
    tbb::parallel_for(0, scan_.scan->rows(), [&](int row) {
      add_row(points, Window(*this, row, half_columns[static_cast<std::size_t>(row)]), normals);
    });
    return normals;
  }

 private:
  // The cells around a cell of one laser, and the angle to the beam of each.
  struct Window {
    Window(const NormalEstimator& of, int laser, int half_columns) : row(laser), half(half_columns) {
      const auto& lasers = of.scan_.scan->model->lasers;
      const int rows = of.parameters_.window_rows / 2;
      const double sine = std::sin(of.parameters_.min_incidence_deg * std::numbers::pi / 180);
      first = std::max(laser - rows, 0);
      last = std::min(laser + rows, static_cast<int>(lasers.size()) - 1);
      for (int r = first; r <= last; ++r) {
        const double up_rad = lasers[static_cast<std::size_t>(r)].elevation_rad -
                              lasers[static_cast<std::size_t>(laser)].elevation_rad;
        for (int across = -half; across <= half; ++across) {
          gate_per_m.push_back(static_cast<float>(std::hypot(up_rad, across * of.column_rad_) / sine));
        }
      }
    }
    int row, half, first, last;     // rows first to last, columns -half to half
    std::vector<float> gate_per_m;  // by row, then column
  };

  // Half the width of the window in columns: at least window_columns, and at least the height of the window.
  [[nodiscard]] int half_width(int laser) const {
    const LidarModel& model = *scan_.scan->model;
    const auto elevation = [&](int l) {
      const int inside = std::clamp(l, 0, static_cast<int>(model.lasers.size()) - 1);
      return model.lasers[static_cast<std::size_t>(inside)].elevation_rad;
    };
    const int rows = parameters_.window_rows / 2;
    const double half_height =
        std::max(elevation(laser + rows) - elevation(laser), elevation(laser) - elevation(laser - rows));
    const int square = static_cast<int>(std::lround(half_height / column_rad_));
    return std::min(std::max(parameters_.window_columns / 2, square), (scan_.scan->columns - 1) / 2);
  }

  // Oriented towards the origin of the ray; zero without a plane.
  [[nodiscard]] Eigen::Vector3f normal(std::size_t i, const Moments& moments) const {
    const std::optional<Eigen::Vector3d> normal = plane_normal(
        moments, {parameters_.min_points, parameters_.max_thickness_ratio, parameters_.min_width_ratio});
    if (!normal) return Eigen::Vector3f::Zero();
    const LidarReturn& r = scan_.scan->returns[i];
    const Laser& laser = scan_.scan->model->lasers[static_cast<std::size_t>(r.laser)];
    const Eigen::Vector3d origin_0 = column_T_0h_[static_cast<std::size_t>(r.column)] * laser.origin_h_m;
    const bool away = normal->dot(origin_0 - scan_.points_0[i]) < 0;
    return (away ? -*normal : *normal).cast<float>();
  }

  // Of points at kLanes columns from `aligned` on, the points of the image around their cells.
  [[nodiscard]] LaneMoments around(const PointImage& points, const Window& window, int aligned,
                                   const LanePoints& centres) const {
    const auto gate_m = static_cast<float>(parameters_.gate_m);
    LaneMoments moments;
    const float* gate_per_m = window.gate_per_m.data();
    for (int row = window.first; row <= window.last; ++row) {
      const auto [x, y, z] = points.at(row, aligned - window.half);
      for (int k = 0; k <= 2 * window.half; ++k) {
        const Floats dx = load(x + k) - centres.x, dy = load(y + k) - centres.y, dz = load(z + k) - centres.z;
        const Floats gate = gate_m + centres.range_m * *gate_per_m++;
        moments.add(dx * dx + dy * dy + dz * dz <= gate * gate, dx, dy, dz);
      }
    }
    return moments;
  }

  void set_lane(LanePoints& centres, int k, const PointImage& points, std::size_t i) const {
    const Eigen::Vector3f p = points.local(scan_.points_0[i]);
    centres.x[k] = p.x();
    centres.y[k] = p.y();
    centres.z[k] = p.z();
    centres.range_m[k] = scan_.scan->returns[i].range_m;
  }

  // The normals of all returns of one laser.
  void add_row(const PointImage& points, const Window& window, std::vector<Eigen::Vector3f>& normals) const {
    const LidarScan& scan = *scan_.scan;
    for (int first = 0; first < scan.columns; first += kLanes) {
      std::array<std::int32_t, kLanes> cells;
      LanePoints centres;
      for (int k = 0; k < kLanes; ++k) {
        const bool inside = first + k < scan.columns;
        cells[static_cast<std::size_t>(k)] =
            inside ? scan.cell(window.row, image_.scan_column(window.row, first + k)) : -1;
        const std::int32_t i = cells[static_cast<std::size_t>(k)];
        if (i >= 0) set_lane(centres, k, points, static_cast<std::size_t>(i));
      }
      if (std::all_of(cells.begin(), cells.end(), [](auto i) { return i < 0; })) continue;
      const LaneMoments moments = around(points, window, first, centres);
      for (int k = 0; k < kLanes; ++k) {
        const std::int32_t i = cells[static_cast<std::size_t>(k)];
        if (i < 0) continue;
        normals[static_cast<std::size_t>(i)] = normal(static_cast<std::size_t>(i), moments.of_lane(k));
      }
    }
    add_shared_cells(points, window, normals);
  }

  // Of several returns in one cell the image has the nearest; here the normals of the others.
  void add_shared_cells(const PointImage& points, const Window& window,
                        std::vector<Eigen::Vector3f>& normals) const {
    const auto& returns = scan_.scan->returns;
    const auto of_row = std::equal_range(returns.begin(), returns.end(), window.row, ByLaser());
    for (auto r = of_row.first; r != of_row.second; ++r) {
      const auto i = static_cast<std::size_t>(r - returns.begin());
      if (scan_.scan->cell(r->laser, r->column) == static_cast<std::int32_t>(i)) continue;
      LanePoints centre;
      set_lane(centre, 0, points, i);
      Moments moments = around(points, window, image_.aligned_column(r->laser, r->column), centre).of_lane(0);
      moments.add(Eigen::Vector3d::Zero());  // itself
      normals[i] = normal(i, moments);
    }
  }
  struct ByLaser {
    bool operator()(const LidarReturn& r, int laser) const { return r.laser < laser; }
    bool operator()(int laser, const LidarReturn& r) const { return laser < r.laser; }
  };

  [[nodiscard]] Moments nearest_in_space(std::size_t i, const NearestNeighbours& neighbours) const {
    const Eigen::Vector3d& p = scan_.points_0[i];
    Moments moments;
    for (const auto& neighbour : neighbours.nearest(p, parameters_.neighbours)) {
      moments.add(scan_.points_0[static_cast<std::size_t>(neighbour.index)] - p);
    }
    return moments;
  }

  const CompensatedScan& scan_;
  const NormalParameters& parameters_;
  AlignedImage image_;
  std::vector<SE3> column_T_0h_;
  double column_rad_;  // rotation of the hub between two columns
};

}  // namespace

std::vector<Eigen::Vector3f> estimate_normals(const CompensatedScan& scan,
                                              const NearestNeighbours& neighbours,
                                              const NormalParameters& parameters) {
  require_within_bounds(parameters, "estimate_normals");
  const NormalEstimator estimator(scan, parameters);
  return parameters.method == NormalMethod::image_window ? estimator.in_image()
                                                         : estimator.in_space(neighbours);
}

}  // namespace mapless
