#pragma once

#include <filesystem>

#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::test {

/// The InputError of opening a recording and reading all of its scans; a failure of the test if there is
/// none.
[[nodiscard]] inline ErrorDetail recording_error(const std::filesystem::path& recording) {
  try {
    const auto dataset = open_dataset(recording);
    for (std::size_t k = 0; k < dataset->size(); ++k) (void)dataset->read(k);
  } catch (const InputError& error) {
    return error.detail();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

}  // namespace mapless::test
