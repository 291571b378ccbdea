#include "export/new_folder.hpp"

#include <string>
#include <system_error>
#include <vector>

#include <mapless/core/errors.hpp>

namespace mapless::app {

namespace fs = std::filesystem;

NewFolder::NewFolder(const fs::path& folder)
    : folder_(fs::absolute(folder / "").lexically_normal().parent_path()) {
  for (fs::path p = folder_; !fs::exists(p); p = p.parent_path()) outermost_ = p;
  std::error_code error;
  fs::create_directories(folder_, error);
  if (!error) return;
  const std::string reason = error.message();
  if (!outermost_.empty()) fs::remove_all(outermost_, error);
  throw OutputError(
      {folder_.string(), "", "", "cannot be made: " + reason, "choose a folder you may write to"});
}

NewFolder::~NewFolder() {
  if (kept_) return;
  std::error_code error;  // what cannot be removed stays
  if (!outermost_.empty()) {
    fs::remove_all(outermost_, error);
    return;
  }
  std::vector<fs::path> inside;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) inside.push_back(entry);
  for (const fs::path& path : inside) fs::remove_all(path, error);
}

}  // namespace mapless::app
