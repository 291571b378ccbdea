#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/memory_dataset.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::MemoryDataset;
using test::regular_starts;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(RecordingSurvey, FindsNothingIrregularInAnOrdinaryRecording) {
  MemoryDataset dataset(regular_starts(5), 8);
  dataset.labels[2] = {251, 9, 9, 0, 0, 0, 0, 0};
  const RecordingSurvey survey = survey_recording(dataset);
  EXPECT_THAT(survey.oddities, IsEmpty());
  EXPECT_EQ(survey.scans, 5u);
  EXPECT_EQ(survey.returns, 40u);
  EXPECT_EQ(survey.median_returns, 8u);
  EXPECT_DOUBLE_EQ(survey.median_period_s, 0.1);
  EXPECT_DOUBLE_EQ(survey.end.seconds(), 0.5);
  EXPECT_EQ(survey.time_source, Provenance::sensor);
  EXPECT_EQ(survey.ring_source, Provenance::recovered_from_order);
  EXPECT_FALSE(survey.compensated);
  EXPECT_EQ(survey.labelled_scans, 1u);
  EXPECT_EQ(survey.moving_points, 1u);
  EXPECT_EQ(survey.still_points, 2u);
}

TEST(RecordingSurvey, FindsGapsRepeatedTimesAndWrongOrder) {
  const auto at = [](double s) { return Time::from_seconds(s); };
  const MemoryDataset dataset({at(0), at(0.1), at(0.1), at(0.2), at(0.5), at(0.45), at(0.55), at(0.65)}, 8);
  EXPECT_THAT(survey_recording(dataset).oddities,
              ElementsAre(HasSubstr("scan 2: the same time as scan 1"), HasSubstr("scan 4: a gap of 0.300 s"),
                          HasSubstr("scan 5: starts 0.050000 s before scan 4")));
}

TEST(RecordingSurvey, FindsUnreadableScansAndOtherSizes) {
  MemoryDataset dataset(regular_starts(6), 8);
  dataset.unreadable = {1};
  dataset.sizes[4] = 7;
  const RecordingSurvey survey = survey_recording(dataset);
  EXPECT_EQ(survey.readable_scans, 5u);
  EXPECT_THAT(survey.oddities,
              ElementsAre(HasSubstr("scan 1: memory: is broken"), HasSubstr("scan 4: 7 records")));
}

TEST(RecordingSurvey, FindsScansWithFewPoints) {
  MemoryDataset dataset(regular_starts(6), 8);
  dataset.missing = {{2, 8}, {3, 5}, {4, 4}};
  const RecordingSurvey survey = survey_recording(dataset);
  EXPECT_EQ(survey.unusable, 17u);
  EXPECT_THAT(survey.oddities, ElementsAre(HasSubstr("scan 2: not one usable point among 8"),
                                           HasSubstr("scan 3: 3 usable points, where 8 is usual"),
                                           HasSubstr("3 scans: 17 records are no usable points (NaN")));
}

TEST(RecordingSurvey, FindsDuplicateScans) {
  const test::TemporaryFolder folder;
  MemoryDataset dataset(regular_starts(3), 8);
  for (const char* bytes : {"first", "other", "first"}) {
    dataset.files.push_back(folder / std::to_string(dataset.files.size()));
    write_file_atomically(dataset.files.back(), bytes);
  }
  EXPECT_THAT(survey_recording(dataset).oddities, ElementsAre("scan 2: the same bytes as scan 0"));
}

TEST(RecordingSurvey, ReportsTheInstantOfMotionCompensation) {
  MemoryDataset dataset(regular_starts(2), 8);
  dataset.compensated_to = Duration::from_seconds(0.05);
  const RecordingSurvey survey = survey_recording(dataset);
  EXPECT_TRUE(survey.compensated);
  EXPECT_NEAR(survey.compensated_to_fraction, 0.5, 1e-9);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
