#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

class RigFileTest : public testing::Test {
 protected:
  [[nodiscard]] std::vector<RigSensor> read(const std::string& text) const {
    write_file_atomically(folder / "rig.yaml", text);
    return read_rig_yaml(folder / "rig.yaml");
  }
  void expect_refused(const std::string& text, const std::string& part) const {
    try {
      static_cast<void>(read(text));
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
      EXPECT_THAT(error.what(), HasSubstr("rig.yaml"));
    }
  }
  test::TemporaryFolder folder;
};

// A quarter turn to the left about z: x of the sensor is y of the vehicle.
TEST_F(RigFileTest, HoldsTheSensorsInOrder) {
  const std::vector<RigSensor> sensors = read(
      "sensors:\n"
      "  - {name: roof, position_m: [0, 0, 1.9], quaternion_xyzw: [0, 0, 0, 1]}\n"
      "  - {name: left, model: VLP-16, position_m: [2, 0.5, 0.6], quaternion_xyzw: [0, 0, 0.70710678, "
      "0.70710678], clock_offset_s: -0.25}\n");
  ASSERT_EQ(sensors.size(), 2u);
  EXPECT_EQ(sensors[0].name, "roof");
  EXPECT_EQ(sensors[0].model, "");
  EXPECT_EQ(sensors[0].clock_offset, Duration());
  EXPECT_TRUE((sensors[0].T_bv * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 0, 1.9)));
  EXPECT_EQ(sensors[1].name, "left");
  EXPECT_EQ(sensors[1].model, "VLP-16");
  EXPECT_EQ(sensors[1].clock_offset, Duration::from_seconds(-0.25));
  EXPECT_TRUE((sensors[1].T_bv * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(2, 1.5, 0.6), 1e-7));
}

TEST_F(RigFileTest, ComesBackAsWritten) {
  const SE3 T(so3_exp({0.3, -1, 2}), {0.1, -2, 1e-3});
  write_rig_yaml(folder / "rig.yaml",
                 {{"a b", SE3(), {}, "OS1-128"}, {"c", T, Duration::from_seconds(0.05), ""}});
  EXPECT_TRUE(is_rig(folder / "."));
  const std::vector<RigSensor> sensors = read_rig_yaml(folder / "rig.yaml");
  ASSERT_EQ(sensors.size(), 2u);
  EXPECT_EQ(sensors[0].name, "a b");
  EXPECT_EQ(sensors[0].model, "OS1-128");
  EXPECT_LT((sensors[1].T_bv.inverse() * T).log().norm(), 1e-14);
  EXPECT_EQ(sensors[1].clock_offset, Duration::from_seconds(0.05));
}

TEST_F(RigFileTest, RefusesWhatIsNoRig) {
  const std::string place = ", position_m: [0, 0, 0], quaternion_xyzw: [0, 0, 0, 1]";
  expect_refused("sensors: []\n", "sensors");
  expect_refused("sensors: [{name: a" + place + "}, {name: a" + place + "}]\n", "name");
  expect_refused("sensors: [{name: ../a" + place + "}]\n", "folder");
  expect_refused("sensors: [{name: a, quaternion_xyzw: [0, 0, 0, 1]}]\n", "position_m");
  expect_refused("sensors: [{name: a, position_m: [0, 0, 0], quaternion_xyzw: [1, 0, 0, 1]}]\n", "unit");
  expect_refused("sensors: [{name: a, clock_offset_s: 1" + place + "}]\n", "first sensor");
  expect_refused("sensors: [{name: a, colour: red" + place + "}]\n", "colour");
  EXPECT_FALSE(is_rig(folder / "nowhere"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
