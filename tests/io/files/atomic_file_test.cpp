#include <filesystem>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

template <class Error, class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(AtomicFile, ReadsBackTheWrittenBytesAndReplacesAnEarlierFile) {
  const test::TemporaryFolder folder;
  const std::string bytes("a\0b\n\xff", 5);
  write_file_atomically(folder / "f", "an older and longer content");
  write_file_atomically(folder / "f", bytes);
  EXPECT_EQ(read_whole_file(folder / "f"), bytes);
  EXPECT_EQ(entries(folder.path()), 1u);
  write_file_atomically(folder / "empty", "");
  EXPECT_EQ(read_whole_file(folder / "empty"), "");
}

TEST(AtomicFile, WritesLargeFilesCompletely) {
  const test::TemporaryFolder folder;
  std::string bytes(3'000'001, 'x');
  bytes.back() = 'y';
  write_file_atomically(folder / "f", bytes);
  EXPECT_EQ(read_whole_file(folder / "f"), bytes);
  EXPECT_FALSE(read_whole_file("/proc/self/status").empty());  // a file whose reported size is 0
}

TEST(AtomicFile, FailureNamesTheFileAndLeavesNothing) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(message_of<OutputError>([&] { write_file_atomically(folder / "no/such/f", "x"); }),
              AllOf(HasSubstr("no/such/f"), HasSubstr("No such file")));
  std::filesystem::create_directories(folder / "taken/by");
  EXPECT_THAT(message_of<OutputError>([&] { write_file_atomically(folder / "taken", "x"); }),
              HasSubstr("taken"));
  EXPECT_EQ(entries(folder.path()), 1u);
  EXPECT_THAT(message_of<OutputError>([&] { write_file_atomically("/dev/full/x", "x"); }),
              HasSubstr("/dev/full/x"));
}

TEST(AtomicFile, AppendsToAnExistingFile) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "f", "a\n");
  append_to_file(folder / "f", "b\n");
  append_to_file(folder / "f", "");
  EXPECT_EQ(read_whole_file(folder / "f"), "a\nb\n");
  EXPECT_THAT(message_of<OutputError>([&] { append_to_file(folder / "g", "x"); }),
              AllOf(HasSubstr("/g"), HasSubstr("No such file")));
  EXPECT_EQ(entries(folder.path()), 1u);
  EXPECT_THAT(message_of<OutputError>([&] { append_to_file("/dev/full", "x"); }), HasSubstr("No space left"));
}

TEST(AtomicFile, WritesThroughALink) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "target", "old");
  std::filesystem::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_whole_file(folder / "target"), "new");
}

TEST(AtomicFile, RefusesToReplaceFoldersAndDevices) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(message_of<OutputError>([&] { write_file_atomically(folder / "pipe", "x"); }),
              AllOf(HasSubstr("pipe"), HasSubstr("not a plain file")));
  EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
}

TEST(AtomicFile, NamesTheReasonOfAFailedRead) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(message_of<InputError>([&] { (void)read_whole_file(folder / "none"); }),
              AllOf(HasSubstr("none"), HasSubstr("No such file")));
  EXPECT_THAT(message_of<InputError>([&] { (void)read_whole_file(folder.path()); }), HasSubstr("a folder"));
}

TEST(AtomicFile, RefusesEndlessAndOversizedFiles) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "huge", "");
  std::filesystem::resize_file(folder / "huge", std::uintmax_t{1} << 40);  // takes no room
  EXPECT_THAT(message_of<InputError>([&] { (void)read_whole_file(folder / "huge"); }),
              AllOf(HasSubstr("huge: cannot be read"), HasSubstr("more than 1073741824 bytes")));
  EXPECT_THAT(message_of<InputError>([] { (void)read_whole_file("/dev/zero"); }),
              AllOf(HasSubstr("/dev/zero"), HasSubstr("more than 67108864 bytes")));
}

TEST(AtomicFile, ManyWritersLeaveOneCompleteFile) {
  const test::TemporaryFolder folder;
  std::vector<std::thread> writers;
  for (char c = 'a'; c < 'e'; ++c) {
    writers.emplace_back([&, c] {
      for (int i = 0; i < 50; ++i) write_file_atomically(folder / "f", std::string(10'000, c));
    });
  }
  for (std::thread& writer : writers) writer.join();
  const std::string bytes = read_whole_file(folder / "f");
  EXPECT_EQ(bytes, std::string(10'000, bytes[0]));
  EXPECT_EQ(entries(folder.path()), 1u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
