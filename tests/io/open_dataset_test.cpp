#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/formats/native/native_writer.hpp"
#include "support/bare_cloud.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using test::TemporaryFolder;
using test::write_text;
using ::testing::HasSubstr;

std::string refusal(const std::filesystem::path& path, const std::string& format = "") {
  DatasetOptions options;
  options.format = format;
  try {
    (void)open_dataset(path, options);
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

TEST(OpenDataset, KnowsTheFormatsOfTheCommandLine) {
  EXPECT_THAT(dataset_formats(),
              ::testing::UnorderedElementsAre("native", "kitti-raw", "kitti", "mdlidar", "pcd"));
}

TEST(OpenDataset, RefusesAFolderWithoutARecording) {
  const TemporaryFolder folder;
  const std::string text = refusal(folder.path());
  EXPECT_THAT(text, HasSubstr(folder.path().string()));
  for (const std::string& format : dataset_formats()) EXPECT_THAT(text, HasSubstr(format));
  EXPECT_THAT(text, HasSubstr("--format"));
}

TEST(OpenDataset, RefusesAFolderWithTwoFormats) {
  const TemporaryFolder folder;
  write_text(folder / "velodyne_points/data/0000000000.bin", "");
  write_text(folder / "velodyne/000000.bin", "");
  const std::string text = refusal(folder.path());
  EXPECT_THAT(text, HasSubstr("kitti-raw, kitti"));
  EXPECT_THAT(text, HasSubstr("--format"));
  // A named format is read as such.
  EXPECT_THAT(refusal(folder.path(), "kitti-raw"), HasSubstr("timestamps_start.txt"));
  EXPECT_THAT(refusal(folder.path(), "kitti"), HasSubstr("times.txt"));
}

TEST(OpenDataset, RefusesUnknownFormatsAndMissingFolders) {
  const TemporaryFolder folder;
  const std::string text = refusal(folder.path(), "las");
  EXPECT_THAT(text, HasSubstr("las"));
  EXPECT_THAT(text, HasSubstr("mdlidar"));
  EXPECT_THAT(refusal(folder / "none"), HasSubstr("no such folder"));
  write_text(folder / "file", "");
  EXPECT_THAT(refusal(folder / "file"), HasSubstr("not a folder"));
}

TEST(OpenDataset, SaysThatThePythonPackageReadsBagsAndCaptures) {
  const TemporaryFolder folder;
  for (const char* name : {"a.bag", "a.mcap", "a.db3", "a.pcap", "a.PCAP", "a.pcapng", "a.osf"}) {
    SCOPED_TRACE(name);
    write_text(folder / name, "");
    EXPECT_THAT(refusal(folder / name), HasSubstr("read by the Python package"));
  }
  const TemporaryFolder rosbag2;
  write_text(rosbag2 / "metadata.yaml", "");
  EXPECT_THAT(refusal(rosbag2.path()), HasSubstr("no recording here"));
  write_text(rosbag2 / "drive_0.db3", "");
  EXPECT_THAT(refusal(rosbag2.path()), HasSubstr("read by the Python package"));
}

TEST(OpenDataset, RefusesANamedFormatThatTheFolderDoesNotHave) {
  const TemporaryFolder folder;
  for (const std::string& format : dataset_formats()) {
    SCOPED_TRACE(format);
    EXPECT_THAT(refusal(folder.path(), format), HasSubstr(folder.path().string()));
  }
}

// What lies beside the recording and cannot be looked into, as lost+found at the root of a disk, does not
// matter.
TEST(OpenDataset, IgnoresUnreadableEntriesBesideARecording) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  EXPECT_THAT(refusal(folder.path()), HasSubstr("no recording here"));
}

// As a folder one may not look into is; but root may look everywhere.
TEST(OpenDataset, NamesAPathThatTheSystemRefuses) {
  const std::string path(300, 'x');
  EXPECT_THAT(refusal(path), ::testing::AllOf(HasSubstr(path), HasSubstr("too long")));
}

TEST(Dataset, AScanNumberBeyondTheEndIsRefused) {
  const TemporaryFolder folder;
  const LidarModel model = test::make_bare_cloud_model(4, 64);
  NativeWriter writer(folder / "recording", model);
  writer.add_scan(Time::from_seconds(0), {});
  writer.finish({});
  const auto dataset = open_dataset(folder / "recording");
  ASSERT_EQ(dataset->size(), 1U);
  EXPECT_NO_THROW((void)dataset->read(0));
  EXPECT_THROW((void)dataset->scan_start(1), ParameterError);
  EXPECT_THROW((void)dataset->scan_end(1), ParameterError);
  EXPECT_THROW((void)dataset->scan_file(1), ParameterError);
  EXPECT_THROW((void)dataset->read(1), ParameterError);
  EXPECT_THROW((void)dataset->read_labels(1), ParameterError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
