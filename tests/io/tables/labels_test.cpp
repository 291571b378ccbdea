#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

TEST(Labels, AreLittleEndianWordsInOrder) {
  const test::TemporaryFolder folder;
  const std::vector<std::uint32_t> labels = {kLabelStatic, kLabelDynamic | 3u << 16, kLabelUnknown};
  write_label_file(folder / "a.label", labels);
  EXPECT_EQ(read_whole_file(folder / "a.label"), std::string("\x09\0\0\0\xfb\0\x03\0\0\0\0\0", 12));
  EXPECT_EQ(read_label_file(folder / "a.label", 3), labels);
  write_label_file(folder / "none.label", {});
  EXPECT_TRUE(read_label_file(folder / "none.label", 0).empty());
}

TEST(Labels, AnotherLengthIsRefused) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "a.label", "1234567");
  for (const std::size_t count : {std::size_t{1}, std::size_t{2}}) {
    try {
      (void)read_label_file(folder / "a.label", count);
      FAIL();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(),
                  ::testing::AllOf(::testing::HasSubstr("a.label"), ::testing::HasSubstr("7 bytes"),
                                   ::testing::HasSubstr(std::to_string(count) + " points")));
    }
  }
  EXPECT_THROW((void)read_label_file(folder / "none.label", 1), InputError);
}

// The last class of SemanticKITTI is 259, another moving vehicle; damaged labels have any.
TEST(Labels, AnotherClassIsRefused) {
  const test::TemporaryFolder folder;
  write_label_file(folder / "a.label", {kLabelStatic, 259u | 65535u << 16});
  EXPECT_EQ(read_label_file(folder / "a.label", 2)[1] & 0xFFFFu, 259u);
  write_label_file(folder / "a.label", {kLabelStatic, 260u});
  try {
    (void)read_label_file(folder / "a.label", 2);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("a.label: label of record 1 = class 260: not a class"));
  }
}

TEST(Labels, MotionFollowsTheMovingObjectConvention) {
  EXPECT_EQ(motion_of_label(kLabelStatic), MotionTruth::still);
  EXPECT_EQ(motion_of_label(kLabelDynamic | 7u << 16), MotionTruth::moving);
  EXPECT_EQ(motion_of_label(259), MotionTruth::moving);
  EXPECT_EQ(motion_of_label(260), MotionTruth::still);
  EXPECT_EQ(motion_of_label(250), MotionTruth::still);
  EXPECT_EQ(motion_of_label(1), MotionTruth::unknown);
  EXPECT_EQ(motion_of_label(5u << 16), MotionTruth::unknown);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
