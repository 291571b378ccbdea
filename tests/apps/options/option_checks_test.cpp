#include "options/option_checks.hpp"

#include <string>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

// A validator returns what is wrong.
bool takes(const CLI::Validator& validator, const std::string& text) { return validator(text).empty(); }

// https://design.ros2.org/articles/topic_and_service_names.html
TEST(OptionChecks, TopicsHaveTheNamesOfRos2) {
  for (const char* name : {"points", "/points", "/lidar_0/points", "~/points", "_a", "/A/b/C9"})
    EXPECT_TRUE(takes(app::topic_name(), name)) << name;
  for (const char* name : {"", "/", "1x", "a b", "a//b", "a/", "/x/", "a/1", "~", "ä", "a\n"})
    EXPECT_FALSE(takes(app::topic_name(), name)) << name;
  EXPECT_FALSE(takes(app::topic_name(), std::string(300, 'a')));
}

TEST(OptionChecks, APrefixBeginsATopic) {
  for (const char* prefix : {"", "mapless/", "/a/b/", "front_"})
    EXPECT_TRUE(takes(app::topic_prefix(), prefix)) << prefix;
  for (const char* prefix : {"a b", "1/", "//", " "})
    EXPECT_FALSE(takes(app::topic_prefix(), prefix)) << prefix;
}

TEST(OptionChecks, AnEmptyTextIsRefused) {
  EXPECT_FALSE(takes(app::not_empty(), ""));
  EXPECT_TRUE(takes(app::not_empty(), "VLP-16"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
