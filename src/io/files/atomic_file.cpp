#include <atomic>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

class FileDescriptor {
 public:
  FileDescriptor(const fs::path& file, int flags) : fd_(open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~FileDescriptor() {
    if (fd_ >= 0) close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] bool valid() const { return fd_ >= 0; }
  [[nodiscard]] int get() const { return fd_; }
  // A full disk may be reported only when the file is closed.
  [[nodiscard]] bool close_checked() { return close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

// Bounds of a file and of a pipe or device [bytes]: larger than any file of a recording and any trajectory;
// /dev/zero is endless.
constexpr std::size_t kLargestFile = std::size_t{1} << 30;
constexpr std::size_t kLargestStream = std::size_t{1} << 26;

std::error_code system_reason() { return {errno, std::generic_category()}; }

[[noreturn]] void refuse_write(const fs::path& file, const std::error_code& reason) {
  throw_write_error(
      {file.string(), "", "", "cannot be written: " + reason.message(), "check the folder and the disk"},
      reason);
}

fs::path beside(const fs::path& file) {
  static std::atomic<unsigned> count = 0;
  return file.parent_path() /
         fmt::format(".{}{}{}-{}", file.filename().string(), kPartialMark, getpid(), count++);
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// A new file: without a name where the file system and /proc allow it, because a process that is killed then
// leaves nothing; else under the name `partial`.
class PartialFile {
 public:
  explicit PartialFile(fs::path partial)
      : partial_(std::move(partial)), fd_(std::in_place, folder_of(partial_), O_WRONLY | O_TMPFILE) {
    unnamed_ = fd_->valid() && access("/proc/self/fd", X_OK) == 0;
    if (!unnamed_) fd_.emplace(partial_, O_WRONLY | O_CREAT | O_EXCL);
  }
  [[nodiscard]] FileDescriptor& fd() { return *fd_; }
  [[nodiscard]] bool give_name() {
    if (!unnamed_) return true;
    const std::string link = fmt::format("/proc/self/fd/{}", fd_->get());
    return linkat(AT_FDCWD, link.c_str(), AT_FDCWD, partial_.c_str(), AT_SYMLINK_FOLLOW) == 0;
  }

 private:
  fs::path partial_;
  std::optional<FileDescriptor> fd_;
  bool unnamed_ = false;
};

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// Where the system cannot synchronise this kind of file (a pipe, a network folder), there is nothing to wait
// for.
bool synchronise(int fd) {
  while (fsync(fd) != 0) {
    if (errno == EINVAL || errno == ENOTSUP || errno == EROFS) return true;
    if (errno != EINTR) return false;
  }
  return true;
}

// Makes the names in the folder of `file` durable.
bool synchronise_folder_of(const fs::path& file) {
  const FileDescriptor opened(folder_of(file), O_RDONLY | O_DIRECTORY);
  if (!opened.valid()) return errno == EACCES;  // a folder that may be written and not read
  return synchronise(opened.get());
}

// The file to replace: the target of a symbolic link, which itself is kept.
fs::path followed(const fs::path& file) {
  std::error_code error;
  const fs::path target = fs::canonical(file, error);
  return error ? file : target;
}

// Why `file` cannot be replaced by a rename, which would remove a device; empty for regular files and free
// names.
std::string why_not_replaceable(const fs::path& file) {
  std::error_code error;
  const fs::file_type type = fs::status(file, error).type();
  if (error || type == fs::file_type::regular || type == fs::file_type::not_found) return "";
  return type == fs::file_type::directory ? "it is a folder" : "it is not a plain file";
}

}  // namespace

void write_file_atomically(const fs::path& file, std::string_view bytes) {
  const fs::path target = followed(file);
  if (const std::string problem = why_not_replaceable(target); !problem.empty()) {
    throw OutputError(
        {file.string(), "", "", "cannot be written: " + problem, "check the folder and the disk"});
  }
  std::error_code ignored;
  const bool replaces = fs::exists(target, ignored);
  const fs::path partial = beside(target);
  PartialFile made(partial);
  FileDescriptor& out = made.fd();
  if (!out.valid()) refuse_write(file, system_reason());
  if (write_all(out.get(), bytes) && synchronise(out.get()) && made.give_name() && out.close_checked() &&
      std::rename(partial.c_str(), target.c_str()) == 0) {
    if (synchronise_folder_of(target)) return;
    const std::error_code reason = system_reason();
    // A new file whose name is not on the disk is none: the caller takes back what belongs to it.
    if (!replaces) unlink(target.c_str());
    refuse_write(file, reason);
  }
  const std::error_code reason = system_reason();
  unlink(partial.c_str());
  refuse_write(file, reason);
}

void append_to_file(const fs::path& file, std::string_view bytes) {
  FileDescriptor out(file, O_WRONLY | O_APPEND);
  struct stat before = {};
  if (!out.valid() || fstat(out.get(), &before) != 0) refuse_write(file, system_reason());
  if (bytes.empty()) return;
  if (write_all(out.get(), bytes) && synchronise(out.get())) {
    if (!out.close_checked()) refuse_write(file, system_reason());
    return;
  }
  const std::error_code reason = system_reason();
  (void)!ftruncate(out.get(), before.st_size);  // the first error is the one to report
  refuse_write(file, reason);
}

GrowingFile::GrowingFile(fs::path file, std::string_view head, Start start) : file_(std::move(file)) {
  if (start == Start::anew) {
    write_file_atomically(file_, head);
    size_ = head.size();
  } else {
    verify(head);
  }
}

void GrowingFile::append(std::string_view bytes) {
  std::error_code error;
  const std::uintmax_t found = fs::file_size(file_, error);
  if (!error && found != size_) fs::resize_file(file_, size_, error);
  if (error) refuse_write(file_, error);
  append_to_file(file_, bytes);
  size_before_ = std::exchange(size_, size_ + bytes.size());
}

void GrowingFile::verify(std::string_view bytes) {
  if (!holds_at(size_, bytes)) {
    throw InputError({file_.string(), "content", fmt::format("byte {}", size_),
                      "differs from what this run computes: the file or the recording has changed",
                      "start anew with --overwrite"});
  }
  size_before_ = std::exchange(size_, size_ + bytes.size());
}

bool GrowingFile::holds_at(std::size_t offset, std::string_view bytes) const {
  const auto refuse = [this](const std::error_code& reason) {
    throw_read_error({file_.string(), "", "", "cannot be read: " + reason.message(), "check the disk"},
                     reason);
  };
  const FileDescriptor in(file_, O_RDONLY);
  if (!in.valid()) refuse(system_reason());
  std::string found(bytes.size(), '\0');
  std::size_t size = 0;
  while (size < found.size()) {
    const ssize_t got =
        pread(in.get(), found.data() + size, found.size() - size, static_cast<off_t>(offset + size));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(system_reason());
    if (got == 0) return false;
    size += static_cast<std::size_t>(got);
  }
  return found == bytes;
}

void GrowingFile::undo_append() {
  size_ = size_before_;
  std::error_code error;
  fs::resize_file(file_, size_, error);
  if (error) refuse_write(file_, error);
}

std::string read_whole_file(const fs::path& file) {
  const auto detail = [&file](const std::string& reason) -> ErrorDetail {
    return {file.string(), "", "", "cannot be read: " + reason, "check the path and its permissions"};
  };
  const auto refuse = [&](const std::string& reason) { throw InputError(detail(reason)); };
  const auto refuse_access = [&] {
    const std::error_code reason = system_reason();
    throw_read_error(detail(reason.message()), reason);
  };
  const FileDescriptor in(file, O_RDONLY);
  if (!in.valid()) refuse_access();
  struct stat status {};
  if (fstat(in.get(), &status) != 0) refuse_access();
  if (S_ISDIR(status.st_mode)) refuse("it is a folder");
  const std::size_t largest = S_ISREG(status.st_mode) ? kLargestFile : kLargestStream;
  const auto require_fitting = [&](std::size_t size) {
    if (size > largest) refuse(fmt::format("it has more than {} bytes", largest));
  };
  require_fitting(static_cast<std::size_t>(status.st_size));
  // One byte more than the size: the end is found without growing the buffer.
  std::string bytes(static_cast<std::size_t>(status.st_size) + 1, '\0');
  std::size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(2 * size);
    const ssize_t got = read(in.get(), bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse_access();
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    require_fitting(size);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace mapless
