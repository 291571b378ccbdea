#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::HasSubstr;

ObjectRow row(std::size_t scan, std::uint32_t id) {
  return {scan,
          Time::from_nanoseconds(1'317'042'272'283'701'593),
          id,
          17,
          {1.5, -2, 3},
          {4, 1.75, 0},
          {0, -3, 0.5},
          {0.25, 0.125, 15},
          3};
}

TEST(ObjectTable, ReadsBackWhatItWrites) {
  const test::TemporaryFolder folder;
  ObjectTableWriter writer(folder / "objects.csv");
  EXPECT_TRUE(read_object_table(folder / "objects.csv").empty());
  writer.add({row(3, 1), row(3, 70000)});
  writer.add({});
  writer.add({row(5, 1)});
  const std::vector<ObjectRow> rows = read_object_table(folder / "objects.csv");
  ASSERT_EQ(rows.size(), 3u);
  const ObjectRow& r = rows[1];
  EXPECT_EQ(r.scan, 3u);
  EXPECT_EQ(r.id, 70000u);
  EXPECT_EQ(r.time, row(0, 1).time);
  EXPECT_EQ(r.points, 17);
  EXPECT_EQ(r.centre_0, Eigen::Vector3d(1.5, -2, 3));
  EXPECT_EQ(r.extent_0, Eigen::Vector3d(4, 1.75, 0));
  EXPECT_EQ(r.velocity_0, Eigen::Vector3d(0, -3, 0.5));
  EXPECT_EQ(r.velocity_std_0, Eigen::Vector3d(0.25, 0.125, 15));
  EXPECT_EQ(r.age, 3);
  EXPECT_EQ(rows[2].scan, 5u);
}

TEST(ObjectTable, NamesTheInvalidLine) {
  const test::TemporaryFolder folder;
  const std::string file = folder / "objects.csv";
  ObjectTableWriter writer(file);
  writer.add({row(3, 1)});
  const std::string good = read_whole_file(file);
  const std::string begin = "4,0.5,2,9,0,0,0,1,1,1,0,0,0";
  for (const std::string& bad :
       {begin + ",1,1,1", begin + ",1,1,1,1,1", begin + ",1,1,0,5", begin + ",1,nan,1,5", begin + ",1,1,1,0",
        "-1" + begin.substr(1) + ",1,1,1,5", std::string("4,noon,2,9,0,0,0,1,1,1,0,0,0,1,1,1,5"),
        std::string("4,0.5,0,9,0,0,0,1,1,1,0,0,0,1,1,1,5"),
        std::string("4,0.5,2,9,0,0,0,1,-1,1,0,0,0,1,1,1,5"),
        std::string("3,0.5,1,9,0,0,0,1,1,1,0,0,0,1,1,1,5"),
        std::string("3,0.5,65536,9,0,0,0,1,1,1,0,0,0,1,1,1,5")}) {
    SCOPED_TRACE(bad);
    std::ofstream(file) << good << bad << "\n";
    try {
      (void)read_object_table(file);
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("objects.csv:3"));
    }
  }
  std::ofstream(file) << "scan,id\n";
  EXPECT_THROW((void)read_object_table(file), InputError);
  EXPECT_THROW((void)read_object_table(folder / "nowhere.csv"), InputError);
}

TEST(ObjectTable, NamesTheReasonOfAFailedWrite) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(ObjectTableWriter(folder / "nowhere" / "objects.csv"), OutputError);
  ObjectTableWriter writer(folder / "objects.csv");
  std::filesystem::remove(folder / "objects.csv");
  EXPECT_THROW(writer.add({row(0, 1)}), OutputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "objects.csv"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
