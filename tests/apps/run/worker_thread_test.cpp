#include "run/worker_thread.hpp"

#include <atomic>
#include <future>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "run/scan_reader.hpp"

namespace mapless::app {
namespace MAPLESS_FILE {

// A scan that is distinguished from others by its start.
InputScan numbered_scan(std::size_t k) {
  LidarScan scan;
  scan.start = Time::from_nanoseconds(static_cast<std::int64_t>(k));
  return {std::make_shared<const LidarScan>(std::move(scan)), k % 2 == 1};
}
std::int64_t number_of(const InputScan& input) { return input.scan->start.nanoseconds(); }

TEST(WorkerThreads, DoEverythingInOrder) {
  std::vector<int> done;
  WorkerThread<int> worker(3, [&done](int n) { done.push_back(n); });
  std::vector<int> given;
  for (int i = 0; i < 1000; ++i) {
    given.push_back(i);
    worker.add(i);
  }
  worker.finish();
  EXPECT_EQ(done, given);
  EXPECT_GE(worker.busy().wall_s, 0);
}

TEST(WorkerThreads, HoldNoMoreThanTheirQueue) {
  std::promise<void> open;
  auto opened = open.get_future().share();
  std::atomic<int> begun = 0;
  WorkerThread<int> worker(2, [&](int) {
    ++begun;
    opened.wait();
  });
  for (int i = 0; i < 3; ++i) worker.add(i);  // one is worked on, two wait
  auto fourth = std::async(std::launch::async, [&] { worker.add(3); });
  EXPECT_LE(begun, 1);
  EXPECT_EQ(fourth.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  open.set_value();
  fourth.get();
  worker.finish();
  EXPECT_EQ(begun, 4);
}

TEST(WorkerThreads, TellTheFirstFailureToWhoeverAddsAndDoNothingAfterIt) {
  std::atomic<int> last = -1;
  WorkerThread<int> worker(2, [&last](int n) {
    last = n;
    if (n == 5) throw std::runtime_error("disk full");
  });
  std::string what;
  try {
    for (int i = 0;; ++i) worker.add(i);
  } catch (const std::runtime_error& error) {
    what = error.what();
  }
  EXPECT_EQ(what, "disk full");
  EXPECT_EQ(last, 5);
  worker.join();
  EXPECT_THROW(worker.finish(), std::runtime_error);
}

TEST(WorkerThreads, GiveUpWhatWaitsWhereTheyEndEarly) {
  std::promise<void> begin;
  std::atomic<bool> ended = false;
  std::atomic<int> done = 0;
  {
    WorkerThread<int> worker(8, [&](int n) {
      if (n == 0) begin.set_value();
      while (n == 0 && !ended) std::this_thread::yield();
      ++done;
    });
    for (int i = 0; i < 5; ++i) worker.add(i);
    begin.get_future().wait();
    ended = true;
  }
  EXPECT_GE(done, 1);
  EXPECT_LE(done, 5);
}

TEST(ScanReaderThreads, ScansComeInOrderAndNotFarAhead) {
  std::atomic<std::size_t> most_read = 0, taken = 10;
  std::atomic<bool> too_far = false;
  ScanReader reader(
      [&](std::size_t k) {
        most_read = k;
        // Two wait, and one is read while one is taken.
        if (k > taken + 4) too_far = true;
        return numbered_scan(k);
      },
      10, 200);
  for (std::size_t k = 10; k < 210; ++k) {
    taken = k;
    const InputScan input = reader.take(k);
    ASSERT_EQ(number_of(input), static_cast<std::int64_t>(k));
    ASSERT_EQ(input.was_compensated, k % 2 == 1);
  }
  EXPECT_EQ(most_read, 209u);
  EXPECT_FALSE(too_far);
}

TEST(ScanReaderThreads, PassOverWhatIsNotTaken) {
  ScanReader reader(
      [](std::size_t k) {
        if (k == 4) throw std::runtime_error("scan 4 is broken");
        return numbered_scan(k);
      },
      0, 100);
  for (const std::size_t k : {0u, 3u, 5u, 70u, 99u}) EXPECT_EQ(number_of(reader.take(k)), k);
}

TEST(ScanReaderThreads, AFailureIsThrownWhereItsScanIsTaken) {
  ScanReader reader(
      [](std::size_t k) {
        if (k == 2) throw std::runtime_error("scan 2 is broken");
        return numbered_scan(k);
      },
      0, 10);
  EXPECT_NO_THROW((void)reader.take(0));
  EXPECT_NO_THROW((void)reader.take(1));
  EXPECT_THROW((void)reader.take(2), std::runtime_error);
}

TEST(ScanReaderThreads, StopBeforeTheEnd) {
  std::atomic<std::size_t> read = 0;
  ScanReader reader(
      [&read](std::size_t k) {
        ++read;
        return numbered_scan(k);
      },
      0, 1'000'000);
  (void)reader.take(0);
  reader.stop();
  EXPECT_LE(read, 5u);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
