#include "io/files/text.hpp"

#include <cstdint>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::write_text;

std::int64_t ns(std::string_view text) {
  const auto time = parse_decimal_seconds(text);
  return time ? time->nanoseconds() : INT64_MIN;
}

TEST(DecimalSeconds, AreParsedExactly) {
  EXPECT_EQ(ns("1317042272.283701593"), 1'317'042'272'283'701'593);
  EXPECT_EQ(ns("0"), 0);
  EXPECT_EQ(ns("-0.5"), -500'000'000);
  EXPECT_EQ(ns("+2"), 2'000'000'000);
  EXPECT_EQ(ns(".25"), 250'000'000);
  EXPECT_EQ(ns("7."), 7'000'000'000);
  EXPECT_EQ(ns("0000000000000000000000000012"), 12'000'000'000);
  EXPECT_EQ(ns("1.317042272283701593e+09"), 1'317'042'272'283'701'593);
  EXPECT_EQ(ns("15E-10"), 2);
  EXPECT_EQ(ns("0.000000000000000001"), 0);
  EXPECT_EQ(ns("1e-300"), 0);
}

TEST(DecimalSeconds, FurtherDigitsRound) {
  EXPECT_EQ(ns("0.0000000014"), 1);
  EXPECT_EQ(ns("0.0000000015"), 2);
  EXPECT_EQ(ns("-0.0000000015"), -2);
  EXPECT_EQ(ns("0.99999999999"), 1'000'000'000);
  EXPECT_EQ(ns("0.0000000005"), 1);
}

TEST(DecimalSeconds, OtherTextIsRefused) {
  for (const char* text :
       {"", "-", ".", "1.2.3", "1,5", "nan", "inf", "1e", "e5", "0x10", "1 2", "--1", "+-1", "9300000000",
        "4000000001", "-4000000001", "1e30", "99999999999999999999999", "1e99999999999"}) {
    EXPECT_FALSE(parse_decimal_seconds(text)) << text;
  }
}

TEST(DecimalSeconds, WrittenTimesReadBack) {
  for (const std::int64_t t : {INT64_C(0), INT64_C(1), INT64_C(-1), INT64_C(-1'500'000'000),
                               INT64_C(1'317'042'272'283'701'593), INT64_C(4'000'000'000'000'000'000)}) {
    EXPECT_EQ(ns(decimal_seconds(Time::from_nanoseconds(t))), t);
  }
  EXPECT_EQ(decimal_seconds(Time::from_nanoseconds(-1)), "-0.000000001");
}

TEST(Text, NumbersAreWholeTexts) {
  EXPECT_EQ(parse_double("-1.5e3"), -1500);
  EXPECT_EQ(parse_double("+3"), 3);
  EXPECT_FALSE(parse_double("3m"));
  EXPECT_FALSE(parse_double(""));
  EXPECT_EQ(parse_integer("-12"), -12);
  EXPECT_FALSE(parse_integer("1.0"));
}

TEST(Text, LinesAndWords) {
  using Parts = std::vector<std::string_view>;
  EXPECT_EQ(split_lines("a\r\n\nb"), (Parts{"a", "", "b"}));
  EXPECT_EQ(split_lines("a\n"), (Parts{"a"}));
  EXPECT_EQ(split_lines(""), Parts{});
  EXPECT_EQ(split_words("  1\t2  3 "), (Parts{"1", "2", "3"}));
  EXPECT_EQ(split_words("   "), Parts{});
}

TEST(ReadLines, LeavesOutLineEndsAndEmptyLinesAtTheEnd) {
  const TemporaryFolder folder;
  write_text(folder / "t.txt", "a\r\n\nb\n\n\n");
  EXPECT_EQ(read_lines(folder / "t.txt"), (std::vector<std::string>{"a", "", "b"}));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
