#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<MotionMeasurement> read(std::vector<MotionMeasurement> (*reader)(const std::filesystem::path&),
                                    const std::string& text) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "measurements.csv";
  std::ofstream(file) << text;
  return reader(file);
}

std::string refusal(const std::string& text) {
  try {
    (void)read(read_speeds, text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(MotionMeasurements, AreRead) {
  const auto speeds = read(read_speeds, "time_s,speed_m_s\n1.5,3\n2,0\n");
  ASSERT_EQ(speeds.size(), 2u);
  EXPECT_EQ(speeds[0].time, Time::from_seconds(1.5));
  EXPECT_EQ(speeds[0].quantity, MeasuredMotion::speed);
  EXPECT_EQ(speeds[0].value, Eigen::Vector3d(3, 0, 0));
  EXPECT_FALSE(speeds[0].sigma);
  const auto turns = read(read_angular_velocities, "time_s,x_rad_s,y_rad_s,z_rad_s\n1,.1,-.2,.3\n");
  ASSERT_EQ(turns.size(), 1u);
  EXPECT_EQ(turns[0].value, Eigen::Vector3d(.1, -.2, .3));
}

// Rates in degrees.
TEST(MotionMeasurements, TurnsFasterThanAnyLidarAreRefused) {
  EXPECT_EQ(read(read_angular_velocities, "time_s,x_rad_s,y_rad_s,z_rad_s\n1,0,0,-49\n").size(), 1u);
  EXPECT_THROW((void)read(read_angular_velocities, "time_s,x_rad_s,y_rad_s,z_rad_s\n1,0,0,-90\n"),
               InputError);
}

TEST(MotionMeasurements, ErrorsNameFileRowFieldAndValue) {
  EXPECT_THAT(refusal("time_s,speed_m_s\n1,2\n1,3\n"), AllOf(HasSubstr(".csv:3"), HasSubstr("time_s")));
  EXPECT_THAT(refusal("time_s,speed_m_s\n1,-2\n"), AllOf(HasSubstr("speed_m_s"), HasSubstr("-2")));
  EXPECT_THAT(refusal("time_s,speed_m_s\n1,nan\n"), AllOf(HasSubstr(".csv:2"), HasSubstr("nan")));
  EXPECT_THAT(refusal("time_s,speed_m_s\n1,1e300\n"), AllOf(HasSubstr(".csv:2"), HasSubstr("200 m/s")));
  EXPECT_THAT(refusal("time,speed\n1,2\n"), HasSubstr("time_s,speed_m_s"));
  EXPECT_THAT(refusal("time_s,speed_m_s\n"), HasSubstr("no measurement"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
