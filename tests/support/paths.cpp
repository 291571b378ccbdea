#include "support/paths.hpp"

namespace mapless::test {

std::filesystem::path shared_data(const std::string& relative) {
  return std::filesystem::path(MAPLESS_SHARED_DATA) / relative;
}

std::filesystem::path test_file(const std::string& relative) {
  return std::filesystem::path(MAPLESS_TESTS) / relative;
}

std::string built_command() { return MAPLESS_COMMAND; }

}  // namespace mapless::test
