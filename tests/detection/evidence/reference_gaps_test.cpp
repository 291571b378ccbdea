#include "detection/evidence/reference_gaps.hpp"

#include <gtest/gtest.h>

namespace mapless {
namespace MAPLESS_FILE {

std::vector<std::size_t> gaps(int references, int first_gap) {
  VotingParameters parameters;
  parameters.references = references;
  parameters.first_gap = first_gap;
  return reference_gaps(parameters);
}

TEST(ReferenceGaps, AreTwoToAnOctave) {
  EXPECT_EQ(gaps(1, 1), (std::vector<std::size_t>{1}));
  EXPECT_EQ(gaps(14, 1), (std::vector<std::size_t>{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128}));
}

TEST(ReferenceGaps, AreTimesTheFirst) {
  EXPECT_EQ(gaps(6, 3), (std::vector<std::size_t>{3, 6, 9, 12, 18, 24}));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
