#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "fuzz/readers.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

namespace fs = std::filesystem;

// A damaged copy that a reader is given, of each kind.
constexpr int kTrials = 5;

std::string with_flipped_bits(std::string bytes, std::mt19937& random) {
  for (int i = 0; i < 3; ++i) bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
  return bytes;
}

std::string with_a_part_twice(const std::string& bytes, std::mt19937& random) {
  const std::size_t from = random() % bytes.size();
  return bytes.substr(0, from + random() % (bytes.size() - from + 1)) + bytes.substr(from);
}

// A number becomes one that overflows what is computed from it.
std::string with_a_huge_number(std::string bytes, std::mt19937& random) {
  const std::size_t at = bytes.find_first_of("123456789", random() % bytes.size());
  return at == std::string::npos ? bytes : bytes.replace(at, 1, "9e300");
}

class DamagedFiles : public ::testing::TestWithParam<fuzz::Reader> {};

// Read, or refused by an Error; no crash, no other exception, and no error of the sanitizers.
TEST_P(DamagedFiles, AreReadOrRefused) {
  const test::TemporaryFolder folder;
  GetParam().write(folder.path());
  const auto refusal = [&](std::string_view bytes) {
    return fuzz::refusal(GetParam(), folder.path(), bytes);
  };
  const std::string right = read_whole_file(folder.path() / GetParam().file);
  ASSERT_EQ(refusal(right), "");
  std::mt19937 random(5);
  (void)refusal("");
  for (int i = 0; i < kTrials; ++i) {
    (void)refusal(right.substr(0, right.size() * static_cast<std::size_t>(i) / kTrials));
    (void)refusal(with_flipped_bits(right, random));
    (void)refusal(with_a_part_twice(right, random));
    (void)refusal(with_a_huge_number(right, random));
  }
  // What fuzzing found (scripts/fuzz.sh).
  const fs::path kept = test::test_file("fuzz/corpus") / GetParam().name;
  if (!fs::is_directory(kept)) return;
  for (const fs::directory_entry& file : fs::directory_iterator(kept)) {
    SCOPED_TRACE(file.path());
    (void)refusal(read_whole_file(file.path()));
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, DamagedFiles, ::testing::ValuesIn(fuzz::readers()),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace MAPLESS_FILE
}  // namespace mapless
