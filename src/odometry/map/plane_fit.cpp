#include "odometry/map/plane_fit.hpp"

#include <Eigen/Eigenvalues>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// Weight, in points, of the expected noise in the thickness of a plane. Chosen: as many as the fewest points
// of a plane, because a plane of a few scan lines looks far thinner than it is (method.md section 6, "Map").
constexpr double kNoisePriorPoints = 6;
// Fewest times its thickness that a plane's medium extent must be (both are variances, [m^2]): points on a
// line, or scattered in all directions, have no normal. Chosen: 1.6 times in length; scattered points have
// about 1.
constexpr double kMinFlatness = 2.5;
// Lines that lasers draw in different scans lie as the motion estimated between these scans puts them: when a
// sensor on its side turns by two laser spacings a scan, the lines of one laser fall on those of another, and
// the map confirms that turn though the true one is faster. A plane that no scan has hit with two lasers is
// therefore uncertain by this much more, and there is none where the points are rougher than so many times
// the noise: in a tree any lines make one. Chosen: the error of the motion of a scan that still counts as
// right (.2 m over four scans), and kGoodSigmas of PlaneMap. Measured (docs/notebook/odometry.md, "Lines of
// different scans"): of 44 VLP-16 recordings 27 windows of four scans err by more than .5 m without, 2 with;
// with .1 m 2, without the second rule 11, without any such plane motorways are lost.
constexpr double kSweptSigma_m = 0.05;
constexpr double kSweptSmoothness = 1.5;
// Distance of a plane from a parallel face of its cube, in standard deviations of the noise: 99 % of the
// points of the surface then lie in the cube.
constexpr double kMinFaceDistanceSigmas = 2.5;

// A face of the cube that is nearly parallel to the plane and close to it separates the points by their
// noise: the points left in the cube lie on one side of the surface.
bool is_cut(const FittedPlane& plane, double cube_m, double sigma_m) {
  Eigen::Index axis = 0;
  const double across = plane.normal.cwiseAbs().maxCoeff(&axis);
  const double distance_to_face = std::min<double>(plane.mean[axis], cube_m - plane.mean[axis]);
  return distance_to_face * across < kMinFaceDistanceSigmas * sigma_m;
}

}  // namespace

FittedPlane fit_plane(const PointSums& sums, bool spanned, double cube_m, double sigma_m) {
  if (sums.count < kMinPlanePoints) return {};
  const double n = sums.count;
  const Vector3d mean = Eigen::Map<const Vector3d>(sums.first.data()) / n;
  Eigen::Matrix3d scatter;
  const auto& s = sums.products;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  scatter = (scatter / n - mean * mean.transpose()).eval();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Vector3d extent = solver.eigenvalues().cwiseMax(0);
  // The fit of the plane took 3 degrees of freedom.
  const double thickness =
      (n * extent[0] + kNoisePriorPoints * sigma_m * sigma_m) / (n - 3 + kNoisePriorPoints);
  if (extent[1] < kMinFlatness * thickness) return {};
  if (!spanned && thickness > kSweptSmoothness * kSweptSmoothness * sigma_m * sigma_m) return {};
  FittedPlane plane;
  plane.mean = mean.cast<float>();
  plane.normal = solver.eigenvectors().col(0).cast<float>();
  plane.middle = solver.eigenvectors().col(1).cast<float>();
  if (is_cut(plane, cube_m, sigma_m)) return {};
  plane.thickness = static_cast<float>(thickness + (spanned ? 0 : kSweptSigma_m * kSweptSigma_m));
  const double uncertainty = thickness / n;
  plane.uncertainty = static_cast<float>(uncertainty);
  plane.per_middle = static_cast<float>(uncertainty / extent[1]);
  plane.per_largest = static_cast<float>(uncertainty / extent[2]);
  return plane;
}

}  // namespace mapless
