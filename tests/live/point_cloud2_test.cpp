#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lidar/scan_builder/raw_points.hpp"
#include "support/paths.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/live/point_cloud2.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAreArray;
using testing::HasSubstr;

// A double resolves Unix seconds to 238 ns, Unix nanoseconds to 256; a float 0.1 s to 8 ns.
constexpr double kResolution_ns = 300;

struct DriverCloud {
  std::string name;
  PointCloud2View view;
  std::vector<std::uint8_t> data;
  json expected;
};

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

// The clouds that python/tests/test_driver_clouds.py reads too.
std::vector<DriverCloud> driver_clouds() {
  std::ifstream file(test::test_file("../python/tests/driver_clouds.json"));
  std::vector<DriverCloud> clouds;
  for (const json& one : json::parse(file)) {
    DriverCloud& cloud = clouds.emplace_back();
    cloud.name = one["name"];
    cloud.data = bytes_of(one["data"]);
    cloud.expected = one["expected"];
    PointCloud2View& view = cloud.view;
    view.stamp = Time::from_nanoseconds(one["stamp_ns"]);
    view.height = one["height"];
    view.width = one["width"];
    view.is_bigendian = one["is_bigendian"];
    view.point_step = one["point_step"];
    view.row_step = one["row_step"];
    for (const json& field : one["fields"])
      view.fields.push_back({field["name"], field["offset"], field["datatype"], field["count"]});
  }
  for (DriverCloud& cloud : clouds) cloud.view.data = cloud.data;
  return clouds;
}

DriverCloud velodyne() { return driver_clouds().front(); }

TEST(PointCloud2, CloudsOfTheDriversAreRead) {
  for (const DriverCloud& cloud : driver_clouds()) {
    SCOPED_TRACE(cloud.name);
    const DriverFields found = read_point_cloud2(cloud.view, "cloud");
    EXPECT_THAT(found.notes, ElementsAreArray(cloud.expected["notes"].get<std::vector<std::string>>()));
    const RawPoints points = read_points(found.fields, "cloud");
    ASSERT_EQ(points.positions.size(), 4U);
    EXPECT_EQ(points.positions[1], Eigen::Vector3f(0, -5, 1));
    const json& rings = cloud.expected["rings"];
    const auto expected_rings =
        rings.is_null() ? std::vector<std::int64_t>() : rings.get<std::vector<std::int64_t>>();
    EXPECT_THAT(points.rings, ElementsAreArray(expected_rings));
    const json& times = cloud.expected["times_since_stamp_ns"];
    ASSERT_EQ(points.times_ns.size(), times.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i].is_null()) continue;  // no return
      const std::int64_t reference = points.times_are_absolute ? cloud.view.stamp.nanoseconds() : 0;
      EXPECT_NEAR(static_cast<double>(points.times_ns[i] - reference), times[i].get<double>(),
                  kResolution_ns);
    }
  }
}

template <class Change>
std::string refusal(Change change) {
  DriverCloud cloud = velodyne();
  cloud.view.data = cloud.data;
  change(cloud.view);
  try {
    (void)read_point_cloud2(cloud.view, "topic points");
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST(PointCloud2, ACloudThatCannotWorkIsRefusedWithFieldAndValue) {
  EXPECT_THAT(refusal([](auto& view) { view.fields.erase(view.fields.begin() + 2); }),
              AllOf(HasSubstr("topic points"), HasSubstr("no field z"), HasSubstr("x, y, intensity")));
  EXPECT_THAT(refusal([](auto& view) { view.fields[4].datatype = 9; }),
              AllOf(HasSubstr("field ring datatype = 9"), HasSubstr("1 to 8")));
  EXPECT_THAT(refusal([](auto& view) { view.fields[5].offset = view.point_step - 3; }),
              AllOf(HasSubstr("field time offset"), HasSubstr("beyond the point_step 22")));
  EXPECT_THAT(refusal([](auto& view) { view.fields[5].offset = 0xffffffff; }),
              HasSubstr("field time offset"));
  EXPECT_THAT(refusal([](auto& view) { view.data = view.data.first(view.data.size() - 1); }),
              AllOf(HasSubstr("data = 87 bytes"), HasSubstr("need 88")));
  EXPECT_THAT(refusal([](auto& view) { view.width = 0xffffffff; }), HasSubstr("row_step = 88"));
  EXPECT_THAT(refusal([](auto& view) { view.fields[0].datatype = 5; }), HasSubstr("not float32 or float64"));
  EXPECT_THAT(refusal([](auto& view) {
                view.fields[3].name = "tag";
                view.fields[4].name = "line";
              }),
              HasSubstr("Livox"));
}

TEST(PointCloud2, MillimetresAreRefused) {
  DriverCloud cloud = velodyne();
  for (std::size_t i = 0; i < cloud.view.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint8_t* at = cloud.data.data() + i * cloud.view.point_step + 4 * k;
      float metres = 0;
      std::memcpy(&metres, at, sizeof(metres));
      metres *= 1000;
      std::memcpy(at, &metres, sizeof(metres));
    }
  }
  cloud.view.data = cloud.data;
  EXPECT_THROW((void)read_point_cloud2(cloud.view, "cloud"), InputError);
}

TEST(PointCloud2, AnEmptyCloudHasFieldsAndNoPoints) {
  DriverCloud cloud = velodyne();
  cloud.view.width = 0;
  cloud.view.row_step = 0;
  cloud.view.data = {};
  const DriverFields found = read_point_cloud2(cloud.view, "cloud");
  EXPECT_EQ(found.fields.x.size, 0U);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
