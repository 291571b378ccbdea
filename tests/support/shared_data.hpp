#pragma once

#include <filesystem>
#include <string>

namespace mapless::test {

/// A path under the shared recordings, which are beside the project and not part of it.
inline std::filesystem::path shared_data(const std::string& relative) {
  return std::filesystem::path(MAPLESS_SHARED_DATA) / relative;
}

}  // namespace mapless::test

/// Skips the test, saying so, where a shared recording is absent.
#define MAPLESS_SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared recording at " << (path)
