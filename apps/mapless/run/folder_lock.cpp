#include "run/folder_lock.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "terminal/stderr.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& what, const std::error_code& reason) {
  throw_write_error({path.string(), "output folder", "", fmt::format("cannot {}: {}", what, reason.message()),
                     "choose a folder you may write to"},
                    reason);
}

std::error_code last_error() { return {errno, std::generic_category()}; }

std::string this_process() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) return fmt::format("process {}", getpid());
  return fmt::format("process {} on {}", getpid(), host.data());
}

// The file may have been removed by its holder between open and flock: then the lock is of no file.
bool is_file(int descriptor, const fs::path& file) {
  struct stat opened = {}, named = {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder, const std::string& holder)
    : file_(fs::absolute(folder) / kLockFile) {
  try {
    make_folder(file_.parent_path());
    acquire();
  } catch (...) {
    remove_made();
    throw;
  }
  const std::string text = fmt::format("{}, {}\n", holder, this_process());
  if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, text.data(), text.size(), 0) < 0)
    say("mapless: {}: cannot be written: {}\n", file_.string(), last_error().message());
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  unlink(file_.c_str());
  close(descriptor_);
  remove_made();
}

void FolderLock::make_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return;
  if (fs::exists(folder, error)) {
    throw OutputError({folder.string(), "output folder", "", "is not a folder", "choose another folder"});
  }
  make_folder(folder.parent_path());
  if (mkdir(folder.c_str(), 0777) == 0) {
    made_.push_back(folder);
  } else if (errno != EEXIST) {
    refuse(folder, "make it", last_error());
  }
}

void FolderLock::acquire() {
  for (;;) {
    const int opened = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (opened < 0) refuse(file_.parent_path(), "write into it", last_error());
    if (flock(opened, LOCK_EX | LOCK_NB) != 0) {
      const bool held = errno == EWOULDBLOCK;
      const std::error_code reason = last_error();
      close(opened);
      if (!held) refuse(file_, "lock it", reason);
      std::string holder = read_whole_file(file_);
      holder.resize(std::min(holder.find('\n'), holder.size()));
      throw TemporaryError({file_.parent_path().string(), "output folder", "",
                            "in use by " + (holder.empty() ? "another run" : holder),
                            "wait for its end, or choose another folder"});
    }
    if (is_file(opened, file_)) {
      descriptor_ = opened;
      return;
    }
    close(opened);
  }
}

void FolderLock::remove_made() {
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) {
    if (rmdir(folder->c_str()) != 0) return;  // not empty
  }
}

}  // namespace mapless::app
