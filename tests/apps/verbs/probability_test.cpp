#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::run_command;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kScans = 12;

TEST(DetectProbability, IsWrittenForEveryRecordIfAskedFor) {
  const test::TemporaryFolder folder;
  test::write_toy_sequence(test::toy_street("VLP-16"), kScans, folder / "street");
  const auto done = run_command({"detect", folder / "street", "-o", folder / "out", "--probability"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const ResultFolder result(folder / "out");
  std::size_t moving = 0;
  double expected = 0;
  for (std::size_t k = 0; k < kScans; ++k) {
    const std::size_t records = std::filesystem::file_size(result.label_file(k)) / 4;
    const auto labels = read_label_file(result.label_file(k), records);
    const auto probabilities = read_probability_file(result.probability_file(k), records);
    for (std::size_t i = 0; i < records; ++i) {
      ASSERT_EQ(std::isnan(probabilities[i]), labels[i] == 0);
      if (motion_of_label(labels[i]) != MotionTruth::moving) continue;
      ++moving;
      expected += static_cast<double>(probabilities[i]);
    }
  }
  EXPECT_GT(moving, 0u);
  const std::string clouds = folder / "clouds";
  ASSERT_EQ(run_command({"export", folder / "street", folder / "out", "--what", "labelled", "-o", clouds})
                .exit_code,
            0);
  EXPECT_THAT(read_whole_file(clouds + "/000009.pcd"),
              HasSubstr("FIELDS x y z label object record probability\n"));
  EXPECT_GT(expected, 0.8 * static_cast<double>(moving));
}

TEST(DetectProbability, IsRefusedForThePublishedMethod) {
  const test::TemporaryFolder folder;
  const auto refused =
      run_command({"detect", folder / "street", "-o", folder / "out", "--probability", "--profile", "paper"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("--probability"), HasSubstr("published")));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
