#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

// Turned by 90 deg about z at (1, 2, 3) in the world: quaternion (0, 0, sin 45 deg, cos 45 deg).
TEST(MotionTable, HasThePoseInTheWorldAndTheUpperHalfOfTheCovariance) {
  const test::TemporaryFolder folder;
  MotionRow row;
  row.scan = 7;
  Eigen::Matrix3d R_0v;
  R_0v << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  row.pose = {Time::from_seconds(1.5), SE3(R_0v, {1, 2, 3}).inverse()};
  row.state = "lost";
  row.inlier_ratio = 0.75;
  row.mean_robust_weight = 0.5;
  row.constraint_ratio = 0.001;
  row.motion_covariance_v << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  write_motion_table(folder / "poses.csv", {row});
  const std::string text = read_whole_file(folder / "poses.csv");
  const std::size_t end_of_head = text.find('\n');
  EXPECT_EQ(text.substr(0, end_of_head),
            "scan,time_s,x_m,y_m,z_m,qx,qy,qz,qw,motion_state,inlier_ratio,mean_robust_weight,"
            "constraint_ratio,cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2");
  EXPECT_EQ(text.substr(end_of_head + 1, 14), "7,1.500000000,");
  EXPECT_TRUE(
      text.ends_with(",lost,0.7500,0.5000,0.001000,"
                     "1.000e+00,2.000e+00,3.000e+00,4.000e+00,5.000e+00,6.000e+00\n"))
      << text;
  std::array<double, 7> pose{};
  std::size_t at = end_of_head + 15;
  for (double& number : pose) {
    std::size_t length = 0;
    number = std::stod(text.substr(at), &length);
    at += length + 1;
  }
  const std::array expected = {1., 2., 3., 0., 0., std::sqrt(0.5), std::sqrt(0.5)};
  for (std::size_t i = 0; i < pose.size(); ++i) EXPECT_NEAR(pose[i], expected[i], 1e-12) << i;
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
