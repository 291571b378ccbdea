#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;

std::string summary_text() { return std::string(kSummaryBegin) + "\n}\n"; }

class ResultFolderTest : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  ResultFolder result{folder / "deep" / "out"};
};

TEST_F(ResultFolderTest, IsCreatedWithItsSummary) {
  result.create(false, summary_text());
  EXPECT_EQ(read_whole_file(result.summary()), summary_text());
  EXPECT_TRUE(fs::is_directory(result.labels()));
  EXPECT_TRUE(fs::is_directory(result.stages()));
  EXPECT_EQ(result.label_file(42), result.path() / "labels" / "000042.label");
  EXPECT_EQ(result.stage_file(1234567), result.path() / "stages" / "1234567.stages");
}

TEST_F(ResultFolderTest, ExistingFolderIsRefusedWithoutOverwrite) {
  result.create(false, summary_text());
  EXPECT_THROW(result.require_free(false), OutputError);
  EXPECT_NO_THROW(result.require_free(true));
}

TEST_F(ResultFolderTest, OverwritingRemovesTheEarlierResultAndNothingElse) {
  result.create(false, summary_text());
  write_label_file(result.label_file(3), {9});
  write_stage_file(result.stage_file(3), {0});
  write_file_atomically(result.config(), "a");
  write_file_atomically(result.path() / "picture.png", "mine");
  write_file_atomically(result.labels() / "notes.txt", "mine");
  write_file_atomically(result.labels() / "3.label", "mine");
  result.create(true, summary_text());
  EXPECT_FALSE(fs::exists(result.label_file(3)));
  EXPECT_FALSE(fs::exists(result.stage_file(3)));
  EXPECT_FALSE(fs::exists(result.config()));
  EXPECT_TRUE(fs::exists(result.path() / "picture.png"));
  EXPECT_TRUE(fs::exists(result.labels() / "notes.txt"));
  EXPECT_TRUE(fs::exists(result.labels() / "3.label"));
}

// A SemanticKITTI sequence has a folder labels of its own.
TEST_F(ResultFolderTest, NeverOverwritesAnotherFolder) {
  fs::create_directories(result.labels());
  write_label_file(result.label_file(0), {9});
  EXPECT_THROW(result.create(true, summary_text()), OutputError);
  write_file_atomically(result.summary(), "{\"program\": \"another\"}");
  EXPECT_THROW(result.create(true, summary_text()), OutputError);
  EXPECT_TRUE(fs::exists(result.label_file(0)));
}

TEST_F(ResultFolderTest, AFolderWithNothingButALockAndAPartOfASummaryIsFree) {
  fs::create_directories(result.path());
  EXPECT_NO_THROW(result.require_free(false));
  write_file_atomically(result.path() / kLockFile, "");
  // Of a run that was killed while it wrote its first file.
  write_file_atomically(result.path() / ".summary.json.partial-17-0", "{\n");
  EXPECT_NO_THROW(result.create(false, summary_text()));
}

TEST_F(ResultFolderTest, AFileInItsPlaceIsRefused) {
  write_file_atomically(folder / "file", "x");
  EXPECT_THROW(ResultFolder(folder / "file").require_free(true), OutputError);
  EXPECT_THROW(ResultFolder(folder / "file" / "out").create(false, summary_text()), OutputError);
}

TEST_F(ResultFolderTest, ListsLabelledScansInOrder) {
  result.create(false, summary_text());
  for (const std::size_t k : {10u, 2u, 1000000u}) write_label_file(result.label_file(k), {9});
  write_file_atomically(result.labels() / "7.label", "");
  write_file_atomically(result.labels() / "000007.txt", "");
  EXPECT_EQ(result.labelled_scans(), (std::vector<std::size_t>{2, 10, 1000000}));
}

TEST_F(ResultFolderTest, StageFilesKeepTheirBytesAndTheirLength) {
  result.create(false, summary_text());
  const std::vector<std::uint8_t> masks = {0, 31, 1, 255};
  write_stage_file(result.stage_file(0), masks);
  EXPECT_EQ(read_stage_file(result.stage_file(0), 4), masks);
  EXPECT_THROW((void)read_stage_file(result.stage_file(0), 5), InputError);
  EXPECT_THROW((void)read_stage_file(result.stage_file(1), 4), InputError);
}

TEST_F(ResultFolderTest, ProbabilitiesKeepTheirValuesAndAreReplacedWithTheResult) {
  result.create(false, summary_text());
  EXPECT_FALSE(fs::exists(result.probabilities()));
  result.create_probabilities();
  const std::vector<float> probabilities = {0, 0.25F, 1};
  write_probability_file(result.probability_file(7), probabilities);
  EXPECT_EQ(result.probability_file(7), result.path() / "probability" / "000007.f32");
  EXPECT_EQ(fs::file_size(result.probability_file(7)), 12u);
  EXPECT_EQ(read_probability_file(result.probability_file(7), 3), probabilities);
  EXPECT_THROW((void)read_probability_file(result.probability_file(7), 4), InputError);
  for (const float wrong : {-0.1F, 1.5F}) {
    write_probability_file(result.probability_file(8), {0.5F, wrong});
    EXPECT_THROW((void)read_probability_file(result.probability_file(8), 2), InputError);
  }
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  write_probability_file(result.probability_file(8), {0.5F, unknown});
  EXPECT_EQ(read_probability_file(result.probability_file(8), 2)[0], 0.5F);
  result.create(true, summary_text());
  EXPECT_FALSE(fs::exists(result.probabilities()));
}

// 200 records, of which every other one has a return.
TEST_F(ResultFolderTest, LabelsOfAnotherScanAreRefused) {
  LidarScan scan;
  scan.input_size = 200;
  std::vector<std::uint32_t> labels(200, kLabelUnknown);
  for (std::uint32_t i = 0; i < 200; i += 2) {
    LidarReturn r{};
    r.position_v.setZero();
    r.input_index = i;
    scan.returns.push_back(r);
    labels[i] = i % 6 == 0 ? kLabelDynamic : kLabelStatic;
  }
  EXPECT_NO_THROW(require_labels_of(scan, labels, "labels"));
  EXPECT_NO_THROW(require_labels_of(scan, std::vector<std::uint32_t>(200, kLabelUnknown), "labels"));
  labels[1] = labels[3] = kLabelStatic;
  EXPECT_NO_THROW(require_labels_of(scan, labels, "labels")) << "1 %";
  labels[4] = kLabelUnknown;
  EXPECT_THROW(require_labels_of(scan, labels, "labels"), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
