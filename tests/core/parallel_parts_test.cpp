#include "core/parallel_parts.hpp"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

TEST(ForParts, VisitsEveryElementOnce) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kPartSize, 3 * kPartSize + 1}) {
    std::vector<int> visits(size, 0);
    std::vector<std::size_t> begins(count_parts(size), size);
    for_parts(size, [&](std::size_t part, std::size_t begin, std::size_t end) {
      begins[part] = begin;
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(size, 1));
    for (std::size_t part = 0; part < begins.size(); ++part) EXPECT_EQ(begins[part], part * kPartSize);
  }
}

// As a loop in order would: whichever part fails first in time.
TEST(ForParts, ThrowsWhatTheFirstPartThrows) {
  for (int repetition = 0; repetition < 20; ++repetition) {
    std::atomic<bool> last_failed = false;
    try {
      for_parts(4 * kPartSize, [&](std::size_t part, std::size_t, std::size_t) {
        if (part == 0) return;
        last_failed = last_failed || part == 3;
        throw std::runtime_error(std::to_string(part));
      });
      FAIL() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "1");
    }
    EXPECT_TRUE(last_failed);
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
