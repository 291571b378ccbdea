#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mapless::app {

/// Keeps other runs out of an output folder during its life, by a lock of the system (flock) on the file
/// `.lock` in it. The system releases the lock where the process is killed, so that the file alone locks
/// nothing.
class FolderLock {
 public:
  /// Makes the folder if it is not there. Throws TemporaryError that names the holder where another process
  /// holds the lock, OutputError where the folder cannot be made or written into. `holder`: the program in
  /// the message of the others, "mapless detect".
  FolderLock(const std::filesystem::path& folder, const std::string& holder);
  /// Removes the file, and the folders it made that are still empty.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  void make_folder(const std::filesystem::path& folder);
  void acquire();
  void remove_made();

  std::filesystem::path file_;
  std::vector<std::filesystem::path> made_;  // the folders, outermost first
  int descriptor_ = -1;
};

}  // namespace mapless::app
