#include "oracle/plane_oracle.hpp"

#include <Eigen/SVD>

namespace mapless::test {

OraclePlane plane_through(const std::vector<Eigen::Vector3d>& points) {
  OraclePlane out;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  out.mean = rows.colwise().mean().transpose();
  rows.rowwise() -= out.mean.transpose();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  out.largest = svd.matrixV().col(0);
  out.middle = svd.matrixV().col(1);
  out.normal = svd.matrixV().col(2);
  out.extent = svd.singularValues().reverse().array().square() / static_cast<double>(points.size());
  return out;
}

double variance_at(const OraclePlane& plane, std::size_t count, double expected, double weight,
                   const Eigen::Vector3d& q) {
  const auto n = static_cast<double>(count);
  const double thickness = (n * plane.extent[0] + weight * expected) / (n - 3 + weight);
  const double along_middle = (q - plane.mean).dot(plane.middle);
  const double along_largest = (q - plane.mean).dot(plane.largest);
  return thickness + thickness / n *
                         (1 + along_middle * along_middle / plane.extent[1] +
                          along_largest * along_largest / plane.extent[2]);
}

}  // namespace mapless::test
