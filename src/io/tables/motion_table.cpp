#include <string>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::string_view kMotionHead =
    "scan,time_s,x_m,y_m,z_m,qx,qy,qz,qw,motion_state,inlier_ratio,mean_robust_weight,"
    "constraint_ratio,cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2\n";

std::string text_of(const MotionRow& row) {
  const SE3 T_0v = row.pose.T_v0.inverse();
  const Eigen::Vector3d& p = T_0v.translation();
  Eigen::Quaterniond q(T_0v.rotation());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Matrix3d& C = row.motion_covariance_v;
  return fmt::format(
      "{},{},{:.4f},{:.4f},{:.4f},{:.7f},{:.7f},{:.7f},{:.7f},{},{:.4f},{:.4f},{:.6f},{:.3e},{:.3e},{:.3e},{:"
      ".3e},"
      "{:.3e},{:.3e}\n",
      row.scan, decimal_seconds(row.pose.time), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w(), row.state,
      row.inlier_ratio, row.mean_robust_weight, row.constraint_ratio, C(0, 0), C(0, 1), C(0, 2), C(1, 1),
      C(1, 2), C(2, 2));
}

}  // namespace

void write_motion_table(const std::filesystem::path& file, const std::vector<MotionRow>& rows) {
  std::string text(kMotionHead);
  for (const MotionRow& row : rows) text += text_of(row);
  write_file_atomically(file, text);
}

}  // namespace mapless
