#pragma once

#include <filesystem>
#include <string>

namespace mapless::test {

/// A fresh folder, removed with all in it at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Writes a file, and makes its folder where there is none.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace mapless::test
