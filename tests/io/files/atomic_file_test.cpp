#include <cerrno>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::atomic_file_calls {

// System calls of this thread, in order: "fsync f", "rename f".
thread_local std::vector<std::string> system_calls;
// Name of the file or folder whose fsync fails.
thread_local std::string failing;
// Whether the process is killed in the next fsync.
thread_local bool killed = false;
// Whether files without a name cannot be given one.
thread_local bool without_proc = false;

void record(const std::string& call, const std::filesystem::path& file) {
  system_calls.push_back(call + " " + file.filename().string());
}

}  // namespace mapless::atomic_file_calls

// In place of those of the C library, which this program therefore does not link.
extern "C" int fsync(int fd) {
  const std::filesystem::path file = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd));
  mapless::atomic_file_calls::record("fsync", file);
  if (mapless::atomic_file_calls::killed) raise(SIGKILL);
  if (file.filename() != mapless::atomic_file_calls::failing) return static_cast<int>(syscall(SYS_fsync, fd));
  errno = EIO;
  return -1;
}
extern "C" int access(const char* file, int mode) noexcept {
  if (mapless::atomic_file_calls::without_proc) return -1;
  return static_cast<int>(syscall(SYS_faccessat, AT_FDCWD, file, mode));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  mapless::atomic_file_calls::record("rename", to);
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

namespace mapless {
namespace MAPLESS_FILE {

using atomic_file_calls::failing;
using atomic_file_calls::system_calls;
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

// The caller has been told that there is no file, and takes back what belongs to it (rows of tables).
TEST(AtomicFile, ANewFileWhoseNameIsNotOnTheDiskIsRemoved) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "f");
  const std::filesystem::path file = std::filesystem::path(folder / "f") / "g";
  failing = "f";
  EXPECT_THROW(write_file_atomically(file, "new"), OutputError);
  EXPECT_EQ(entries(folder / "f"), 0u);
  failing.clear();
  write_file_atomically(file, "old");
  failing = "f";
  EXPECT_THROW(write_file_atomically(file, "new"), OutputError);
  EXPECT_EQ(entries(folder / "f"), 1u);  // the old one or the new one, whole
  failing.clear();
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

TEST(AtomicFileDeathTest, AKilledProcessLeavesNothing) {
  const test::TemporaryFolder folder;
  const int unnamed = open(folder.path().c_str(), O_WRONLY | O_TMPFILE, 0600);
  if (unnamed < 0) GTEST_SKIP() << "no files without a name on this file system";
  close(unnamed);
  EXPECT_EXIT(
      {
        atomic_file_calls::killed = true;
        write_file_atomically(folder / "f", "x");
      },
      testing::KilledBySignal(SIGKILL), "");
  EXPECT_EQ(entries(folder.path()), 0u);
}

// After a power cut the disk holds what was synchronised: the content first, then its name.
TEST(AtomicFile, SynchronisesTheContentBeforeTheRenameAndTheFolderAfterIt) {
  const test::TemporaryFolder folder;
  for (const bool named : {false, true}) {
    atomic_file_calls::without_proc = named;
    system_calls.clear();
    write_file_atomically(folder / "f", named ? "named" : "unnamed");
    ASSERT_EQ(system_calls.size(), 3u);
    const auto with_name = testing::StartsWith("fsync .f.partial");
    const auto without_name = testing::StartsWith(named ? "fsync .f.partial" : "fsync #");
    EXPECT_THAT(system_calls[0], testing::AnyOf(without_name, with_name));
    EXPECT_EQ(system_calls[1], "rename f");
    EXPECT_EQ(system_calls[2], "fsync " + folder.path().filename().string());
    EXPECT_EQ(read_whole_file(folder / "f"), named ? "named" : "unnamed");
    EXPECT_EQ(entries(folder.path()), 1u);
  }
  atomic_file_calls::without_proc = false;
  system_calls.clear();
  append_to_file(folder / "f", "y");
  EXPECT_EQ(system_calls, (std::vector<std::string>{"fsync f"}));
}

TEST(GrowingFile, GoesOnAfterTheRowsOfAnEarlierRunAndReplacesTheRest) {
  const test::TemporaryFolder folder;
  GrowingFile(folder / "f", "head\n", GrowingFile::Start::anew).append("one\ntwo\nthr");
  GrowingFile file(folder / "f", "head\n", GrowingFile::Start::resumed);
  file.verify("one\n");
  EXPECT_THAT(message_of<InputError>([&] { file.verify("other\n"); }),
              AllOf(HasSubstr("/f"), HasSubstr("byte 9")));
  file.verify("two\n");
  file.append("");
  EXPECT_EQ(read_whole_file(folder / "f"), "head\none\ntwo\n");
  file.append("three\n");
  file.append("four\n");
  file.undo_append();
  EXPECT_EQ(read_whole_file(folder / "f"), "head\none\ntwo\nthree\n");
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
