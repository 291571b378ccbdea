#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::run_command;

// The recording of the first sensor, in the frame of the vehicle, is that of the scene's own sensor; the
// other is 2 m ahead of it and 1.4 m below, at every instant.
TEST(SimulateRig, WritesARecordingPerSensorOfOneDrive) {
  const test::TemporaryFolder folder;
  const SE3 T_bumper(Eigen::Matrix3d::Identity(), {2, 0, -1.4});
  write_rig_yaml(folder / "two.yaml", {{"roof", SE3(), {}, "VLP-16"}, {"bumper", T_bumper, {}, "VLP-16"}});
  const auto run = run_command({"simulate", "crossing", "--rig", folder / "two.yaml", "-o", folder / "rig",
                                "--duration-s", "0.2", "--seed", "3"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto one = run_command({"simulate", "crossing", "--sensor", "VLP-16", "-o", folder / "one",
                                "--duration-s", "0.2", "--seed", "3"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const fs::path rig = folder / "rig", alone = folder / "one";
  for (const char* file : {"scans/000001.pcd", "labels/000001.label", "trajectory.txt", "objects.csv"})
    EXPECT_EQ(read_whole_file(rig / "roof" / file), read_whole_file(alone / file)) << file;
  EXPECT_EQ(read_rig_yaml(rig / "rig.yaml").size(), 2u);

  const auto roof = open_dataset(rig / "roof"), bumper = open_dataset(rig / "bumper");
  ASSERT_EQ(bumper->size(), 2u);
  for (const double t : {0.0, 0.07, 0.15}) {
    const SE3 T = roof->trajectory()->at(Time::from_seconds(t)).T_v0 *
                  bumper->trajectory()->at(Time::from_seconds(t)).T_v0.inverse();
    EXPECT_LT((T.inverse() * T_bumper).log().norm(), 1e-6);
  }
  // Another noise: at equal cells of sky and far ground the ranges would be the same otherwise.
  EXPECT_NE(read_whole_file(rig / "roof" / "scans/000001.pcd"),
            read_whole_file(rig / "bumper" / "scans/000001.pcd"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
