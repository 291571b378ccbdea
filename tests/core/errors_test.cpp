#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

TEST(Errors, MessageIsOneLineOfAllParts) {
  const InputError error({"a/times.txt", "line 3", "1.5", "not after 1.6", "sort the file"});
  EXPECT_STREQ(error.what(), "a/times.txt: line 3 = 1.5: not after 1.6; sort the file");
  EXPECT_EQ(error.detail().field, "line 3");
}

TEST(Errors, EmptyPartsAreLeftOut) {
  EXPECT_STREQ(InputError({"", "", "", "no scans", ""}).what(), "no scans");
  EXPECT_STREQ(InputError({"a.pcd", "", "", "empty", "record again"}).what(), "a.pcd: empty; record again");
  EXPECT_STREQ(InputError({"a.pcd", "", "7", "too many", ""}).what(), "a.pcd: 7: too many");
  EXPECT_STREQ(InputError({"a.pcd", "WIDTH", "", "missing", ""}).what(), "a.pcd: WIDTH: missing");
}

TEST(Errors, LineBreaksInValuesDoNotBreakTheLine) {
  EXPECT_STREQ(InputError({"a", "b", "1\n2\r3", "bad", ""}).what(), "a: b = 1 2 3: bad");
}

TEST(Errors, ControlCharactersAreReplaced) {
  const std::string value("1\0\x1b[2J\x7f", 7);
  EXPECT_STREQ(InputError({"a", "b", value, "bad", "mend it"}).what(), "a: b = 1??[2J?: bad; mend it");
}

TEST(Errors, LongValuesAreShortened) {
  const std::string message = InputError({"a", "b", std::string(100'000, 'x'), "bad", "mend it"}).what();
  EXPECT_LT(message.size(), 300u);
  EXPECT_TRUE(message.ends_with("xxx...: bad; mend it")) << message;
}

TEST(Errors, LongProblemsAreShortened) {
  const std::string message = InputError({"a", "b", "c", std::string(10'000, 'x'), "mend it"}).what();
  EXPECT_LT(message.size(), 700u);
  EXPECT_TRUE(message.ends_with("xxx...; mend it")) << message;
}

TEST(Errors, LongValuesAreCutBetweenUtf8Characters) {
  std::string value = "x";
  while (value.size() < 1000) value += "\u00e4";  // two bytes, of which every second place is within
  const std::string message = InputError({"a", "b", value, "bad", "mend it"}).what();
  EXPECT_TRUE(message.ends_with("\u00e4...: bad; mend it")) << message;
}

TEST(Errors, LongPlacesKeepTheirEnds) {
  const std::string path = "/folder/" + std::string(5000, 'y') + "/000007.pcd";
  const std::string message = InputError({path, "", "", "bad", "mend it"}).what();
  EXPECT_LT(message.size(), 430u);
  EXPECT_TRUE(message.starts_with("/folder/yyy")) << message;
  EXPECT_TRUE(message.ends_with("yyy/000007.pcd: bad; mend it")) << message;
}

TEST(Errors, EveryKindIsAnError) {
  EXPECT_THROW(throw InputError({"", "", "", "p", ""}), Error);
  EXPECT_THROW(throw ParameterError({"", "", "", "p", ""}), Error);
  EXPECT_THROW(throw TrajectoryDomainError({"", "", "", "p", ""}), Error);
  EXPECT_THROW(throw OutputError({"", "", "", "p", ""}), Error);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
