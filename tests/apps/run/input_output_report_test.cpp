#include "run/input_output_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mapless::app {
namespace MAPLESS_FILE {

using testing::HasSubstr;
using testing::Not;

TEST(InputOutputReport, SaysNothingOfADiskThatKeepsUp) {
  InputOutputReport report;
  EXPECT_EQ(trouble(report), "");
  report.run_s = 100;
  report.waited_for_reading_s = 9;
  report.reading = {90, 30};
  EXPECT_EQ(trouble(report), "");
  report.run_s = 2;
  report.waited_for_reading_s = 0.9;
  EXPECT_EQ(trouble(report), "") << "a short run is no measurement";
}

TEST(InputOutputReport, TellsASlowDiskFromSlowDecoding) {
  InputOutputReport report;
  report.run_s = 50;
  report.waited_for_reading_s = 20;
  report.reading = {40, 4};
  EXPECT_THAT(trouble(report), HasSubstr("waited 20.0 s (40 % of the run) for reading"));
  EXPECT_THAT(trouble(report), HasSubstr("the disk is slow"));
  report.reading = {40, 36};
  EXPECT_THAT(trouble(report), HasSubstr("the disk is not what is slow"));
  report.waited_for_writing_s = 10;
  report.writing = {10, 1};
  EXPECT_THAT(trouble(report), HasSubstr("(20 % of the run) for writing"));
}

TEST(InputOutputReport, AsJson) {
  InputOutputReport report;
  report.run_s = 50;
  report.waited_for_writing_s = 5;
  report.writing = {10, 1};
  const auto json = to_json(report);
  EXPECT_EQ(json["run_s"], 50);
  EXPECT_EQ(json["writing"]["waited_s"], 5);
  EXPECT_EQ(json["writing"]["waited_share"], 0.1);
  EXPECT_EQ(json["writing"]["busy_s"], 10);
  EXPECT_EQ(json["writing"]["processor_s"], 1);
  EXPECT_EQ(json["reading"]["waited_share"], 0);
  EXPECT_EQ(to_json(InputOutputReport{})["reading"]["waited_share"], 0) << "of no time at all";
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
