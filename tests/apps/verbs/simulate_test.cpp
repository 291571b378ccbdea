#include <csignal>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>

#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;
using test::CommandResult;
using test::run_command;
using testing::HasSubstr;

TEST(Simulate, SameSeedGivesTheSameBytesAtAnyNumberOfThreadsAndLongerOnlyGoesOn) {
  const test::TemporaryFolder folder;
  const std::string one = (folder.path() / "one").string();
  const std::string two = (folder.path() / "two").string();
  const CommandResult first = run_command(
      {"simulate", "tunnel", "-o", one, "--sensor", "VLP-16", "--duration-s", "0.2", "--threads", "1"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("2 scans of tunnel"));
  ASSERT_EQ(
      run_command({"simulate", "tunnel", "-o", two, "--sensor", "VLP-16", "--duration-s", "0.5"}).exit_code,
      0);
  for (const char* file :
       {"scans/000000.pcd", "scans/000001.pcd", "labels/000001.label", "objects.csv", "sensor.yaml"})
    EXPECT_EQ(read_whole_file(fs::path(one) / file), read_whole_file(fs::path(two) / file)) << file;
  for (const char* file : {"times.txt", "trajectory.txt", "object_states.csv"}) {
    const std::string part = read_whole_file(fs::path(one) / file);
    EXPECT_EQ(part, read_whole_file(fs::path(two) / file).substr(0, part.size())) << file;
  }
}

TEST(Simulate, ItsTruthIsDrawnFromSeveralScansWithoutAResult) {
  const test::TemporaryFolder folder;
  const std::string recording = (folder.path() / "out").string();
  ASSERT_EQ(run_command({"simulate", "tunnel", "-o", recording, "--sensor", "VLP-16", "--duration-s", "0.3"})
                .exit_code,
            0);
  const auto drawn = [&](const std::vector<std::string>& more) {
    const fs::path picture = folder.path() / "picture.png";
    std::vector<std::string> arguments = {"render", recording, "--scan", "1", "-o", picture.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = run_command(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_whole_file(picture);
  };
  const std::string one = drawn({});
  EXPECT_TRUE(drawn({}) == one);
  EXPECT_NE(drawn({"--around", "1"}), one);
  EXPECT_LT(drawn({"--reduce", "2"}).size(), one.size());
}

TEST(Simulate, WrongUseIsOneLineAndLeavesNothingBehind) {
  const test::TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"simulate", "nowhere", "-o", out},
        {"simulate", "town1", "-o", out, "--sensor", "HDL-65"},
        {"simulate", "town1", "-o", out, "--duration-s", "0.01"},
        {"simulate", "town1", "-o", out, "--format", "las"}}) {
    const CommandResult result = run_command(arguments);
    EXPECT_NE(result.exit_code, 0);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(out));
  }
  const CommandResult existing = run_command({"simulate", "town1", "-o", folder.path().string()});
  EXPECT_EQ(existing.exit_code, 1);
  EXPECT_THAT(existing.err, HasSubstr("exists already"));
}

/// A small file system of its own, where this process may mount one.
class SmallDisk {
 public:
  explicit SmallDisk(fs::path folder) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
    mounted_ = mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=6m") == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount(folder_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  [[nodiscard]] bool is_there() const { return mounted_; }

 private:
  fs::path folder_;
  bool mounted_ = false;
};

TEST(Simulate, WhatIsFinishedWhenTheDiskIsFullIsARecording) {
  const test::TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk");
  if (!disk.is_there()) GTEST_SKIP() << "no small file system can be mounted here (that needs root)";
  for (const char* format : {"native", "mdlidar", "kitti"}) {
    for (const char* sensor : {"VLP-16", "HDL-64E-S2"}) {
      SCOPED_TRACE(std::string(format) + " " + sensor);
      const fs::path out = folder.path() / "disk" / "out";
      const CommandResult result = run_command({"simulate", "flyer", "-o", out.string(), "--sensor", sensor,
                                                "--format", format, "--duration-s", "30"});
      EXPECT_EQ(result.exit_code, 75);
      EXPECT_THAT(result.err, HasSubstr("No space left on device"));
      EXPECT_GE(open_dataset(out)->size(), 1u);
      EXPECT_TRUE(open_dataset(out)->read_labels(0));
      fs::remove_all(out);
    }
  }
}

TEST(Simulate, WhatIsFinishedAtAnInterruptIsARecording) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    SCOPED_TRACE(testing::Message() << "signal " << signal);
    const test::TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    test::RunningCommand command(
        {"simulate", "flyer", "-o", out.string(), "--sensor", "VLP-16", "--duration-s", "200"});
    ASSERT_TRUE(command.wait_for_error_line("1 of 2000"));
    command.send(signal);
    const CommandResult result = command.wait();
    EXPECT_EQ(result.exit_code, 128 + signal);
    EXPECT_THAT(result.err, HasSubstr("valid shorter sequence"));
    const auto dataset = open_dataset(out);
    EXPECT_GE(dataset->size(), 1u);
    EXPECT_LT(dataset->size(), 2000u);
    EXPECT_TRUE(dataset->read_labels(0));
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
