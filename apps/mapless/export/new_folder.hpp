#pragma once

#include <filesystem>

namespace mapless::app {

/// A new or empty folder for files that belong together: unless they are kept, what was made is removed, the
/// folders above it too. So an export that fails leaves nothing that looks complete.
class NewFolder {
 public:
  /// Throws OutputError where the folder cannot be made. It must not exist, or be empty.
  explicit NewFolder(const std::filesystem::path& folder);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void keep() { kept_ = true; }

 private:
  std::filesystem::path folder_, outermost_;  // the first folder that was made; empty: none
  bool kept_ = false;
};

}  // namespace mapless::app
