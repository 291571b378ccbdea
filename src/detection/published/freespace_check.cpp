#include "detection/published/freespace_check.hpp"

#include <algorithm>
#include <cmath>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/published/ray_search.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

// A point of the query scan, with its normal there.
struct Query {
  Eigen::Vector3d q_0;
  Eigen::Vector3d normal_0;  // zero: none
  [[nodiscard]] bool has_normal() const { return !normal_0.isZero(0); }
};

class FreespaceCheck {
 public:
  FreespaceCheck(const CompensatedScan& reference, double threshold_m, const FreespaceParameters& parameters)
      : reference_(reference),
        search_(reference),
        image_(*reference.scan),
        threshold_m_(threshold_m),
        parameters_(parameters) {
    for (int l = 0; l < scan().rows(); ++l)
      widest_step_ = std::max(widest_step_, scan().model->elevation_step(l));
  }

  [[nodiscard]] FreespaceVerdict verdict(const Query& query) const {
    const NearestRay ray = parameters_.require_near_ray
                               ? search_.nearest(query.q_0, near_limit(search_.longest_range(query.q_0)))
                               : search_.nearest(query.q_0);
    if (!ray.found() || (parameters_.require_near_ray && ray.distance_m > near_limit(ray))) {
      return FreespaceVerdict::unobserved;
    }
    if (window_touches(query, ray)) return FreespaceVerdict::border;
    const std::int32_t cell = scan().cell(ray.laser, ray.column);
    switch (code_of_cell(cell)) {
      case ReturnCode::hit:
        return against_endpoint(query, ray, reference_.points_0[static_cast<std::size_t>(cell)]);
      case ReturnCode::nothing:
        return parameters_.no_return_is_free && ray.range_m <= scan().model->max_range_m
                   ? FreespaceVerdict::inside
                   : FreespaceVerdict::unobserved;
      case ReturnCode::faulty:
      case ReturnCode::absent:
        break;
    }
    return FreespaceVerdict::unobserved;
  }

 private:
  [[nodiscard]] const LidarScan& scan() const { return *reference_.scan; }

  // Largest distance of the nearest ray from a point it observes.
  [[nodiscard]] double near_limit(const NearestRay& ray) const {
    const double spacing = scan().model->elevation_step(ray.laser);
    return parameters_.max_ray_distance_m + parameters_.max_ray_distance_spacings * spacing * ray.range_m;
  }

  // At least that of any ray within `range_m`.
  [[nodiscard]] double near_limit(double range_m) const {
    return parameters_.max_ray_distance_m + parameters_.max_ray_distance_spacings * widest_step_ * range_m;
  }

  // Whether any ray around the nearest one ends right at the point: a surface seen there that its neighbours
  // missed.
  [[nodiscard]] bool window_touches(const Query& query, const NearestRay& ray) const {
    const int half_rows = parameters_.border_window_rows / 2;
    const int half_columns = parameters_.border_window_columns / 2;
    if (half_rows == 0 && half_columns == 0) return false;
    const double radius = threshold_m_ + parameters_.border_radius_per_m * ray.range_m;
    const int centre = image_.aligned_column(ray.laser, ray.column);
    for (int row = std::max(0, ray.laser - half_rows);
         row <= std::min(scan().rows() - 1, ray.laser + half_rows); ++row) {
      for (int column = centre - half_columns; column <= centre + half_columns; ++column) {
        const std::int32_t cell = scan().cell(row, image_.scan_column(row, column));
        if (cell < 0) continue;
        const Eigen::Vector3d& p = reference_.points_0[static_cast<std::size_t>(cell)];
        if ((p - query.q_0).squaredNorm() <= radius * radius) return true;
      }
    }
    return false;
  }

  // With the plane of the point: an endpoint beyond it is inside, on it border, short of it outside.
  [[nodiscard]] FreespaceVerdict against_endpoint(const Query& query, const NearestRay& ray,
                                                  const Eigen::Vector3d& p_0) const {
    const Eigen::Vector3d origin = reference_.ray_origin_0(ray.laser, ray.column);
    if (query.has_normal()) {
      const double to_endpoint = query.normal_0.dot(p_0 - query.q_0);
      const double to_origin = query.normal_0.dot(origin - query.q_0);
      // A ray that starts on the plane itself runs along it, and cannot be beyond or short of it.
      if (std::abs(to_origin) > threshold_m_) {
        if (std::abs(to_endpoint) <= threshold_m_) return FreespaceVerdict::border;
        return (to_endpoint > 0) == (to_origin > 0) ? FreespaceVerdict::outside : FreespaceVerdict::inside;
      }
    }
    if ((p_0 - query.q_0).norm() <= threshold_m_) return FreespaceVerdict::border;
    return (p_0 - origin).norm() > ray.range_m ? FreespaceVerdict::inside : FreespaceVerdict::outside;
  }

  const CompensatedScan& reference_;
  RaySearch search_;
  AlignedImage image_;
  double threshold_m_;
  double widest_step_ = 0;  // between the elevations of two lasers [rad]
  const FreespaceParameters& parameters_;
};

}  // namespace

std::vector<FreespaceVerdict> check_freespace(const PreparedScan& query,
                                              const std::vector<std::int32_t>& queries,
                                              const CompensatedScan& reference, double threshold_m,
                                              const FreespaceParameters& parameters) {
  std::vector<FreespaceVerdict> verdicts(queries.size(), FreespaceVerdict::unobserved);
  if (queries.empty()) return verdicts;
  const FreespaceCheck check(reference, threshold_m, parameters);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, queries.size(), 256), [&](const auto& chunk) {
    for (std::size_t i = chunk.begin(); i != chunk.end(); ++i) {
      const auto index = static_cast<std::size_t>(queries[i]);
      verdicts[i] = check.verdict({query.compensated.points_0[index], query.normals_0[index].cast<double>()});
    }
  });
  return verdicts;
}

}  // namespace mapless
