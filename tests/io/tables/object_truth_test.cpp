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

constexpr const char* kHead = "scan,object_id,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,speed_mps\n";

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

std::string message_of(const std::filesystem::path& folder) {
  try {
    (void)read_object_truth(folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ObjectTruth, IsEmptyWithoutTables) {
  const test::TemporaryFolder folder;
  const ObjectTruth truth = read_object_truth(folder.path());
  EXPECT_FALSE(truth.has_descriptions || truth.has_states);
}

TEST(ObjectTruth, ReadsBothTables) {
  const test::TemporaryFolder folder;
  write(folder / "objects.csv", "object_id,class,kind\n7,car,mover\n65535,person,parked\n");
  write(folder / "object_states.csv", std::string(kHead) + "3,7,0.350000001,1,-2,3.5,0,3,-4,5\n");
  const ObjectTruth truth = read_object_truth(folder.path());
  EXPECT_TRUE(truth.has_descriptions && truth.has_states);
  EXPECT_EQ(truth.descriptions.at(7).object_class, "car");
  EXPECT_EQ(truth.descriptions.at(65535).kind, "parked");
  const ObjectState& state = truth.states.at({3, 7});
  EXPECT_EQ(state.time.nanoseconds(), 350'000'001);
  EXPECT_EQ(state.centre_0, Eigen::Vector3d(1, -2, 3.5));
  EXPECT_EQ(state.velocity_0, Eigen::Vector3d(0, 3, -4));
  EXPECT_EQ(state.speed_mps, 5);
}

TEST(ObjectTruth, ATableOfClassesAloneLeavesTheKindsOpen) {
  const test::TemporaryFolder folder;
  write(folder / "objects.csv", "id,class\n7,car\n8,person\n");
  const ObjectTruth truth = read_object_truth(folder.path());
  EXPECT_TRUE(truth.has_descriptions);
  EXPECT_EQ(truth.descriptions.at(8).object_class, "person");
  EXPECT_EQ(truth.descriptions.at(8).kind, "");
}

TEST(ObjectTruth, RefusesInvalidObjects) {
  const test::TemporaryFolder folder;
  const std::string head = "object_id,class,kind\n";
  for (const std::string& text : {std::string(), std::string("id,class,kind\n"), head + "0,car,mover\n",
                                  head + "65536,car,mover\n", head + "x,car,mover\n", head + "1,car\n",
                                  head + "1,car,mover,2\n", head + "1,car,mover\n1,van,mover\n"}) {
    SCOPED_TRACE(text);
    write(folder / "objects.csv", text);
    EXPECT_THAT(message_of(folder.path()), HasSubstr("objects.csv"));
  }
  EXPECT_THAT(message_of(folder.path()), HasSubstr("objects.csv:3"));
}

TEST(ObjectTruth, RefusesInvalidStates) {
  const test::TemporaryFolder folder;
  for (const std::string row :
       {"-1,7,0,1,2,3,4,5,6,7", "1,7,soon,1,2,3,4,5,6,7", "1,7,0,nan,2,3,4,5,6,7", "1,7,0,1,2,3,4,5,6,-7",
        "1,7,0,1,2,3,4,5,6", "1,7,0,1,2,3,4,5,6,7\n1,7,0,1,2,3,4,5,6,7"}) {
    SCOPED_TRACE(row);
    write(folder / "object_states.csv", kHead + row + "\n");
    EXPECT_THAT(message_of(folder.path()), HasSubstr("object_states.csv:"));
  }
}

TEST(ObjectTruth, NamesTheColumnOfAnInvalidNumber) {
  const test::TemporaryFolder folder;
  write(folder / "object_states.csv", std::string(kHead) + "1,7,0,1,2,3,4,nan,6,7\n");
  EXPECT_THAT(message_of(folder.path()), HasSubstr("object_states.csv:2: vy_mps = nan: not a finite number"));
}

TEST(ObjectStatesWriter, IsReadableAfterEveryScan) {
  const test::TemporaryFolder folder;
  ObjectStatesWriter writer(folder / "object_states.csv");
  EXPECT_TRUE(read_object_truth(folder.path()).states.empty());
  ObjectState state;
  state.time = Time::from_seconds(0.05);
  state.centre_0 = {1, 2, -3};
  state.velocity_0 = {0.3, -0.4, 0};
  state.speed_mps = 0.5;
  writer.add(0, {{2, state}, {9, state}});
  writer.add(1, {});
  EXPECT_EQ(read_object_truth(folder.path()).states.size(), 2u);
  writer.add(2, {{2, state}});
  const ObjectTruth truth = read_object_truth(folder.path());
  EXPECT_EQ(truth.states.size(), 3u);
  EXPECT_EQ(truth.states.at({2, 2}).velocity_0, state.velocity_0);
  EXPECT_EQ(truth.states.at({2, 2}).time, state.time);
}

TEST(ObjectStatesWriter, NamesTheReasonOfAFailedWrite) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(ObjectStatesWriter(folder / "nowhere" / "object_states.csv"), OutputError);
  ObjectStatesWriter writer(folder / "object_states.csv");
  std::filesystem::remove(folder / "object_states.csv");
  std::filesystem::create_directory(folder / "object_states.csv");
  EXPECT_THROW(writer.add(0, {{1, ObjectState{}}}), OutputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
