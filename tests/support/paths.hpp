#pragma once

#include <filesystem>
#include <string>

namespace mapless::test {

// Where the tests find what is not compiled into them. These functions alone know the folders of this
// checkout, so that a compiler cache serves all other sources of the tests in every checkout.

/// A path under the shared recordings, which are beside the project and not part of it.
[[nodiscard]] std::filesystem::path shared_data(const std::string& relative);

/// A path under tests/.
[[nodiscard]] std::filesystem::path test_file(const std::string& relative);

/// The built command `mapless`.
[[nodiscard]] std::string built_command();

}  // namespace mapless::test

/// Skips the test, saying so, where a shared recording is absent.
#define MAPLESS_SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared recording at " << (path)
