#include "run/real_time_pace.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mapless::app {
namespace MAPLESS_FILE {

using testing::ElementsAre;
using testing::HasSubstr;

// Scans of 100 ms; time goes on only by sleeping and by `work`.
class RealTimePaceTest : public testing::Test {
 protected:
  static constexpr std::int64_t kMs = 1'000'000;

  static Time at_ms(std::int64_t ms) { return Time::from_nanoseconds(ms * kMs); }
  Clock clock() {
    return {[this] { return now; },
            [this](Time until) {
              EXPECT_LE((until - now).seconds(), 0.0500001) << "an interrupt would be noticed too late";
              now = std::max(now, until);
            }};
  }
  // Recorded long ago, played now.
  RealTimePace pace(int scans) {
    std::vector<Time> ends;
    for (int k = 0; k < scans; ++k) ends.push_back(at_ms(7000 + 100 * (k + 1)));
    return {at_ms(7000), ends, clock()};
  }
  void work(std::int64_t ms) { now = now + Duration::from_nanoseconds(ms * kMs); }
  // Takes scans until the end, `ms` of work for each; their numbers.
  std::vector<std::size_t> play(RealTimePace& pace, const std::vector<std::int64_t>& ms) {
    std::vector<std::size_t> taken;
    while (const auto k = pace.next([] { return false; })) {
      work(ms.at(taken.size()));
      pace.answered(*k);
      taken.push_back(*k);
    }
    return taken;
  }

  Time now = Time::from_nanoseconds(500'000 * kMs);
};

TEST_F(RealTimePaceTest, AScanIsThereOnceItsLastRayIsMeasured) {
  RealTimePace p = pace(3);
  const Time start = now;
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(p.next([] { return false; }), std::optional<std::size_t>(k));
    EXPECT_EQ((now - start).nanoseconds(), 100 * (k + 1) * kMs);
    work(30);
    p.answered(static_cast<std::size_t>(k));
  }
  EXPECT_EQ(p.next([] { return false; }), std::nullopt);
  EXPECT_EQ(p.report().scans, 3u);
  EXPECT_EQ(p.report().late, 0u);
  EXPECT_EQ(p.report().dropped, 0u);
  for (const double ms : p.report().latency_ms) EXPECT_NEAR(ms, 30, 1e-6);
}

// The second scan takes 250 ms: scans 2 and 3 come meanwhile, at 300 and 400 ms, and 4 while 3 is worked on.
TEST_F(RealTimePaceTest, ScansThatComeMeanwhileWaitAndAreLate) {
  RealTimePace p = pace(6);
  EXPECT_THAT(play(p, {10, 250, 40, 40, 10, 10}), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(p.report().late, 3u);
  EXPECT_EQ(p.report().dropped, 0u);
  // Done at 110, 450, 490, 530, 540, 610 ms; measured at 100, 200, ...
  ASSERT_EQ(p.report().latency_ms.size(), 6u);
  const std::vector<double> expected = {10, 250, 190, 130, 40, 10};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(p.report().latency_ms[k], expected[k], 1e-6) << k;
}

// The first scan takes 800 ms: at 900 ms scans 1 to 8 have come, of which the last five are still there.
TEST_F(RealTimePaceTest, OfMoreThanTheQueueHoldsTheOldestAreDropped) {
  RealTimePace p = pace(10);
  EXPECT_THAT(play(p, std::vector<std::int64_t>{800, 1, 1, 1, 1, 1, 1}), ElementsAre(0, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(p.report().dropped, 3u);
  EXPECT_EQ(p.report().late, 5u);
  EXPECT_EQ(p.report().scans, 10u);
  const auto json = to_json(p.report());
  EXPECT_EQ(json["dropped"], 3);
  EXPECT_EQ(json["queue"], 5);
  EXPECT_NEAR(json["latency"]["max_ms"].get<double>(), 800, 1e-6);
  EXPECT_THAT(text_of(p.report()), HasSubstr("5 of 10 scans late"));
  EXPECT_THAT(text_of(p.report()), HasSubstr("3 dropped"));
}

TEST_F(RealTimePaceTest, AnInterruptEndsTheSleep) {
  RealTimePace p = pace(2);
  int calls = 0;
  EXPECT_EQ(p.next([&calls] { return ++calls == 2; }), std::nullopt);
  EXPECT_LT((now - at_ms(500'000)).seconds(), 0.1);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
