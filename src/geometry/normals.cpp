#include <algorithm>
#include <optional>

#include <Eigen/Eigenvalues>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mapless/geometry/normals.hpp>
#include <mapless/lidar/aligned_image.hpp>

namespace mapless {
namespace {

// Below this share of the largest variance the middle one is rounding, not width: the closed form loses half
// the digits where two eigenvalues coincide.
constexpr double kRounding = 1e-6;

// First and second moments of points about a reference near them, so that world coordinates of kilometres
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

// Normal of the plane through the points, of either sign, where they are a plane.
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
      : scan_(scan), neighbours_(neighbours), parameters_(parameters), image_(*scan.scan) {
    const LidarModel& model = *scan.scan->model;
    for (std::size_t c = 0; c < scan.column_T_0v.size(); ++c) {
      const SE3 T_vh(rotation_z(model.hub_angle(static_cast<double>(c))), Eigen::Vector3d::Zero());
      column_T_0h_.push_back(scan.column_T_0v[c] * T_vh);
    }
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
  [[nodiscard]] Eigen::Vector3d ray_origin_0(std::size_t i) const {
    const LidarReturn& r = scan_.scan->returns[i];
    const Laser& laser = scan_.scan->model->lasers[static_cast<std::size_t>(r.laser)];
    return column_T_0h_[static_cast<std::size_t>(r.column)] * laser.origin_h_m;
  }

  [[nodiscard]] Moments around_in_image(std::size_t i) const {
    const LidarScan& scan = *scan_.scan;
    const LidarReturn& r = scan.returns[i];
    const double gate = parameters_.gate_m + parameters_.gate_per_m * r.range_m;
    const int rows = parameters_.window_rows / 2;
    const int columns = std::min(parameters_.window_columns, scan.columns);
    const int first_column = image_.aligned_column(r.laser, r.column) - columns / 2;
    const int last_row = std::min(r.laser + rows, scan.rows() - 1);
    Moments moments;
    moments.add(Eigen::Vector3d::Zero());
    for (int row = std::max(r.laser - rows, 0); row <= last_row; ++row) {
      for (int column = first_column; column < first_column + columns; ++column) {
        const std::int32_t j = scan.cell(row, image_.scan_column(row, column));
        if (j < 0 || static_cast<std::size_t>(j) == i) continue;
        const Eigen::Vector3d d = scan_.points_0[static_cast<std::size_t>(j)] - scan_.points_0[i];
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
};

}  // namespace

std::vector<Eigen::Vector3f> estimate_normals(const CompensatedScan& scan,
                                              const NearestNeighbours& neighbours,
                                              const NormalParameters& parameters) {
  const NormalEstimator estimator(scan, neighbours, parameters);
  std::vector<Eigen::Vector3f> normals(scan.points_0.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, normals.size(), 512), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) normals[i] = estimator.normal(i);
  });
  return normals;
}

}  // namespace mapless
