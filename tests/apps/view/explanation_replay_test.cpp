#include "view/explanation_replay.hpp"

#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

// A run of 100 scans, each of which is known two scans later. Counts the runs and the scans.
struct MadeRun {
  std::atomic<int> runs = 0, scans = 0;

  void replay(const ExplanationReplay::Explained& explained, const ExplanationReplay::Take& take) {
    ++runs;
    std::vector<std::size_t> marked;
    const auto finish = [&](std::size_t end) {
      while (!marked.empty() && marked.front() < end) {
        take(marked.front(), marked.front() == 77 ? "" : "block " + std::to_string(marked.front()));
        marked.erase(marked.begin());
      }
    };
    for (std::size_t k = 0; k < 100; ++k) {
      if (explained(k)) marked.push_back(k);
      ++scans;
      finish(k < 2 ? 0 : k - 1);
    }
    finish(100);
  }
};

struct ExplanationReplayTest : testing::Test {
  MadeRun run;
  ExplanationReplay explanations{
      [this](const auto& explained, const auto& take) { run.replay(explained, take); }};

  HttpAnswer wait_for(std::size_t scan) {
    HttpAnswer answer = explanations.answer(scan);
    while (answer.status == 202) {
      std::this_thread::yield();
      answer = explanations.answer(scan);
    }
    return answer;
  }
};

TEST_F(ExplanationReplayTest, GoesOnForLaterScansAndBeginsAnewForEarlierOnes) {
  EXPECT_EQ(run.runs, 0);  // nothing is wanted
  EXPECT_EQ(wait_for(40).body, "block 40");
  EXPECT_LE(run.scans, 44);  // no farther than it must
  EXPECT_EQ(wait_for(41).body, "block 41");
  EXPECT_EQ(wait_for(60).body, "block 60");
  EXPECT_EQ(run.runs, 1);
  EXPECT_EQ(wait_for(20).body, "block 20");
  EXPECT_EQ(run.runs, 2);
  EXPECT_LE(run.scans, 64 + 24);  // the first run is abandoned
  EXPECT_EQ(wait_for(99).body, "block 99");
  EXPECT_EQ(run.runs, 2);
  EXPECT_EQ(wait_for(0).body, "block 0");
  EXPECT_EQ(run.runs, 3);
}

TEST_F(ExplanationReplayTest, EveryScanCanBeWantedInAnyOrder) {
  for (std::size_t k = 0; k < 100; ++k) {
    const std::size_t scan = k * 37 % 100;
    if (scan == 77) continue;
    EXPECT_EQ(wait_for(scan).body, "block " + std::to_string(scan));
  }
}

TEST_F(ExplanationReplayTest, AScanWithoutExplanationIsNotWaitedFor) {
  EXPECT_EQ(wait_for(77).status, 404);
  EXPECT_EQ(wait_for(100).status, 404);  // beyond the run
  EXPECT_EQ(wait_for(50).body, "block 50");
}

TEST_F(ExplanationReplayTest, EndsInTheMiddle) { EXPECT_EQ(explanations.answer(99).status, 202); }

TEST(ExplanationReplay, SaysWhyARunCannotBeRepeated) {
  ExplanationReplay explanations([](const auto&, const auto&) {
    throw InputError({"summary.json", "version", "0", "is not 1", "label it again"});
  });
  HttpAnswer answer = explanations.answer(3);
  while (answer.status == 202) answer = explanations.answer(3);
  EXPECT_EQ(answer.status, 404);
  EXPECT_THAT(answer.body, testing::HasSubstr("label it again"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
