#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "geometry/nearest_neighbours.hpp"
#include "lidar/aligned_image.hpp"
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/geometry/normals.hpp>

namespace mapless::inline v1 {
namespace {

// Below this share of the largest variance the middle one is rounding error, not width: the closed form has
// half the digits of a double (1e-8) where two eigenvalues coincide.
constexpr double kRounding = 1e-6;
// Normals per parallel task. Chosen: half of kPointsPerTask of sensor_motion.hpp, as a normal takes longer
// than a point.
constexpr std::size_t kNormalsPerTask = 512;

// First and second moments of points relative to a reference near them: world coordinates of kilometres then
// cost no digits.
class Moments {
 public:
  void add(const Eigen::Vector3d& d) {
    ++count_;
    sum_ += d;
    squares_.noalias() += d * d.transpose();
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d mean = sum_ / count_;
    return squares_ / count_ - mean * mean.transpose();
  }

 private:
  int count_ = 0;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares_ = Eigen::Matrix3d::Zero();
};

// Normal of the plane through the points, of either sign, if they lie on a plane.
std::optional<Eigen::Vector3d> plane_normal(const Moments& moments, const NormalParameters& parameters) {
  if (moments.count() < parameters.min_points) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.covariance());
  const Eigen::Array3d variances = solver.eigenvalues().array().max(0.0);
  const double thickness = parameters.max_thickness_ratio * parameters.max_thickness_ratio;
  const double width = std::max(parameters.min_width_ratio * parameters.min_width_ratio, kRounding);
  if (variances[2] <= 0 || variances[1] < width * variances[2]) return std::nullopt;
  if (variances[0] > thickness * variances[1]) return std::nullopt;
  return solver.eigenvectors().col(0);
}

class NormalEstimator {
 public:
  NormalEstimator(const CompensatedScan& scan, const NearestNeighbours& neighbours,
                  const NormalParameters& parameters)
      : scan_(scan),
        neighbours_(neighbours),
        parameters_(parameters),
        image_(*scan.scan),
        column_rad_(2 * std::numbers::pi / scan.scan->model->columns),
        sine_of_incidence_(std::sin(parameters.min_incidence_deg * std::numbers::pi / 180)) {
    const LidarModel& model = *scan.scan->model;
    for (std::size_t c = 0; c < scan.column_T_0v.size(); ++c) {
      const SE3 T_vh(rotation_z(model.hub_angle(static_cast<double>(c))), Eigen::Vector3d::Zero());
      column_T_0h_.push_back(scan.column_T_0v[c] * T_vh);
    }
    for (int l = 0; l < scan.scan->rows(); ++l) half_columns_.push_back(half_width(model, l));
  }

  [[nodiscard]] Eigen::Vector3f normal(std::size_t i) const {
    const Moments moments =
        parameters_.method == NormalMethod::image_window ? around_in_image(i) : nearest_in_space(i);
    const std::optional<Eigen::Vector3d> normal = plane_normal(moments, parameters_);
    if (!normal) return Eigen::Vector3f::Zero();
    const bool away = normal->dot(ray_origin_0(i) - scan_.points_0[i]) < 0;
    return (away ? -*normal : *normal).normalized().cast<float>();
  }

 private:
  // Half the width of the window in columns: at least window_columns, and at least the height of the window.
  [[nodiscard]] int half_width(const LidarModel& model, int laser) const {
    const auto elevation = [&](int l) {
      const int inside = std::clamp(l, 0, static_cast<int>(model.lasers.size()) - 1);
      return model.lasers[static_cast<std::size_t>(inside)].elevation_rad;
    };
    const int rows = parameters_.window_rows / 2;
    const double half_height =
        std::max(elevation(laser + rows) - elevation(laser), elevation(laser) - elevation(laser - rows));
    const int square = static_cast<int>(std::lround(half_height / column_rad_));
    return std::min(std::max(parameters_.window_columns / 2, square), (model.columns - 1) / 2);
  }

  [[nodiscard]] Eigen::Vector3d ray_origin_0(std::size_t i) const {
    const LidarReturn& r = scan_.scan->returns[i];
    const Laser& laser = scan_.scan->model->lasers[static_cast<std::size_t>(r.laser)];
    return column_T_0h_[static_cast<std::size_t>(r.column)] * laser.origin_h_m;
  }

  [[nodiscard]] Moments around_in_image(std::size_t i) const {
    const LidarScan& scan = *scan_.scan;
    const LidarReturn& r = scan.returns[i];
    const auto& lasers = scan.model->lasers;
    const double elevation = lasers[static_cast<std::size_t>(r.laser)].elevation_rad;
    const int rows = parameters_.window_rows / 2;
    const int half = half_columns_[static_cast<std::size_t>(r.laser)];
    const int centre = image_.aligned_column(r.laser, r.column);
    const int last_row = std::min(r.laser + rows, scan.rows() - 1);
    Moments moments;
    moments.add(Eigen::Vector3d::Zero());
    for (int row = std::max(r.laser - rows, 0); row <= last_row; ++row) {
      const double up_rad = lasers[static_cast<std::size_t>(row)].elevation_rad - elevation;
      for (int across = -half; across <= half; ++across) {
        const std::int32_t j = scan.cell(row, image_.scan_column(row, centre + across));
        if (j < 0 || static_cast<std::size_t>(j) == i) continue;
        const Eigen::Vector3d d = scan_.points_0[static_cast<std::size_t>(j)] - scan_.points_0[i];
        const double gate =
            parameters_.gate_m + r.range_m * std::hypot(up_rad, across * column_rad_) / sine_of_incidence_;
        if (d.squaredNorm() <= gate * gate) moments.add(d);
      }
    }
    return moments;
  }

  [[nodiscard]] Moments nearest_in_space(std::size_t i) const {
    const Eigen::Vector3d& p = scan_.points_0[i];
    Moments moments;
    for (const auto& neighbour : neighbours_.nearest(p, parameters_.neighbours)) {
      moments.add(scan_.points_0[static_cast<std::size_t>(neighbour.index)] - p);
    }
    return moments;
  }

  const CompensatedScan& scan_;
  const NearestNeighbours& neighbours_;
  const NormalParameters& parameters_;
  AlignedImage image_;
  std::vector<SE3> column_T_0h_;
  double column_rad_;  // rotation of the hub between two columns
  double sine_of_incidence_;
  std::vector<int> half_columns_;  // of each laser's window
};

}  // namespace

std::vector<Eigen::Vector3f> estimate_normals(const CompensatedScan& scan,
                                              const NearestNeighbours& neighbours,
                                              const NormalParameters& parameters) {
  require_within_bounds(parameters, "estimate_normals");
  const NormalEstimator estimator(scan, neighbours, parameters);
  std::vector<Eigen::Vector3f> normals(scan.points_0.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, normals.size(), kNormalsPerTask),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i)
                        normals[i] = estimator.normal(i);
                    });
  return normals;
}

}  // namespace mapless
