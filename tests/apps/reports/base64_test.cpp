#include "reports/base64.hpp"

#include <gtest/gtest.h>

namespace mapless::app {
namespace MAPLESS_FILE {

// RFC 4648, section 10, and bytes above 127.
TEST(Base64, OfTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFF\xEF"), "/+8=");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
