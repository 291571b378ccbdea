#include "io/formats/kitti/kitti_files.hpp"

#include <gtest/gtest.h>

#include "support/bare_cloud.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::write_text;

TEST(ParseDateTime, IsExactToTheNanosecond) {
  // date -u -d '2011-09-26 13:04:32' +%s
  EXPECT_EQ(parse_date_time("2011-09-26 13:04:32.283701593", "f:1").nanoseconds(), 1317042272283701593);
  EXPECT_EQ(parse_date_time("1970-01-01 00:00:00.5", "f:1").nanoseconds(), 500000000);
  EXPECT_EQ(parse_date_time("1970-01-01 00:00:01", "f:1").nanoseconds(), 1000000000);
}

TEST(ParseDateTime, CrossesMidnightAndTheEndOfFebruary) {
  const Time before = parse_date_time("2012-02-29 23:59:59.999999999", "f:1");
  EXPECT_EQ((parse_date_time("2012-03-01 00:00:00.000000001", "f:2") - before).nanoseconds(), 2);
}

TEST(ParseDateTime, RefusesOtherText) {
  for (const char* text : {"", "2011-09-26", "2011-09-26 13:04", "2011-13-26 13:04:32", "2011-02-30 13:04:32",
                           "2011-09-26 24:04:32", "2011-09-26 13:04:32.", "2011-09-26 13:04:32.1x",
                           "1317042272.28", "2011-09-26 13:04:32.1234567890", "9999-01-01 00:00:00"}) {
    SCOPED_TRACE(text);
    try {
      (void)parse_date_time(text, "times.txt:3");
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.detail().where, "times.txt:3");
    }
  }
}

TEST(ReadKittiCloud, RefusesTruncatedAndEmptyFiles) {
  const TemporaryFolder folder;
  write_text(folder / "empty.bin", "");
  write_text(folder / "cut.bin", std::string(47, 'x'));
  for (const char* name : {"empty.bin", "cut.bin"}) {
    SCOPED_TRACE(name);
    try {
      (void)read_kitti_cloud(folder / name);
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.detail().where, (folder / name).string());
      EXPECT_EQ(error.detail().field, "size");
      EXPECT_FALSE(error.detail().remedy.empty());
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
