#include "io/formats/kitti/kitti_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

class KittiCalibrationFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    test::write_text(folder_ / name, text);
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

TEST_F(KittiCalibrationFile, ReadsTheCalibrationOfKittiOdometry) {
  const auto file = write("calib.txt",
                          "P0: 7.188560000000e+02 0 6.071928e+02 0 0 7.18856e+02 1.852157e+02 0 0 0 1 0\n"
                          "Tr: 0 -1 0 -0.01 0 0 -1 -0.08 1 0 0 -0.27\n");
  const SE3 T_cam_velo = read_kitti_calibration(file);
  EXPECT_LT((T_cam_velo * Eigen::Vector3d(10, 1, 2) - Eigen::Vector3d(-1.01, -2.08, 9.73)).norm(), 1e-12);
}

TEST_F(KittiCalibrationFile, ReadsTheCalibrationOfKittiRawWithItsRectification) {
  const auto file = write("calib_velo_to_cam.txt",
                          "calib_time: 15-Mar-2012\nR: 0 -1 0 0 0 -1 1 0 0\nT: -0.01 -0.08 -0.27\n");
  const Eigen::Vector3d p(10, 1, 2);
  EXPECT_LT((read_kitti_calibration(file) * p - Eigen::Vector3d(-1.01, -2.08, 9.73)).norm(), 1e-12);
  write("calib_cam_to_cam.txt", "S_rect_00: 1 2\nR_rect_00: 0 -1 0 1 0 0 0 0 1\n");
  EXPECT_LT((read_kitti_calibration(file) * p - Eigen::Vector3d(2.08, -1.01, 9.73)).norm(), 1e-12);
}

TEST_F(KittiCalibrationFile, RefusesBadCalibrations) {
  const auto refuses = [this](const std::string& text) -> std::string {
    try {
      (void)read_kitti_calibration(write("calib.txt", text));
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_THAT(refuses(""), HasSubstr("not found"));
  EXPECT_THAT(refuses("R: 1 0 0 0 1 0 0 0 1\n"), HasSubstr("T: not found"));
  EXPECT_THAT(refuses("Tr: 1 0 0 0\n"), AllOf(HasSubstr("4 numbers"), HasSubstr("12")));
  EXPECT_THAT(refuses("Tr: 2 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("not a rotation"));
  const std::string right = "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
  EXPECT_THAT(refuses(right + right), HasSubstr("Tr: is there twice"));
  EXPECT_THAT(refuses("Tr: 1 0 0 nan 0 1 0 0 0 0 1 0\n"), HasSubstr("nan"));
  EXPECT_THROW((void)read_kitti_calibration(folder_ / "absent.txt"), InputError);
}

TEST_F(KittiCalibrationFile, ReadsTheCalibrationOfARealDrive) {
  const auto date = test::shared_data("kitti_raw/2011_09_26");
  const auto file = date / "calib_velo_to_cam.txt";
  MAPLESS_SKIP_WITHOUT(file);
  // The lidar is 0.27 m behind the camera and 0.08 m above it; both face forward.
  const SE3 T_cam_velo = read_kitti_calibration(file);
  EXPECT_LT((T_cam_velo * Eigen::Vector3d(10, 0, 0) - Eigen::Vector3d(0, -0.08, 9.73)).norm(), 0.3);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
