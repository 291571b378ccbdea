#include "view/explanation_replay.hpp"

#include <exception>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace mapless::app {
namespace {

// Neighbours of a wanted scan are explained with it: a user steps to them next.
constexpr std::size_t kBefore = 2, kBehind = 8;

struct Abandoned {};  // thrown through a replay that is of no more use

}  // namespace

ExplanationReplay::~ExplanationReplay() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

HttpAnswer ExplanationReplay::answer(std::size_t scan) {
  const std::lock_guard lock(mutex_);
  const auto found = blocks_.find(scan);
  if (found != blocks_.end() && found->second.empty())
    return {404, {}, "No point of this scan can be explained.\n"};
  if (found != blocks_.end()) return {200, "application/octet-stream", found->second};
  if (!failure_.empty()) return {404, {}, failure_};
  wanted_ = scan;
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  changed_.notify_all();
  return {202, {}, fmt::format("The detector runs again: scan {}, up to {}.\n", next_, scan)};
}

void ExplanationReplay::run() {
  for (;;) {
    std::unique_lock lock(mutex_);
    marked_.clear();
    changed_.wait(lock, [this] { return ending_ || wanted_; });
    if (ending_) return;
    const auto at_first = wanted_;
    lock.unlock();
    try {
      replay_([this](std::size_t scan) { return explained(scan); },
              [this](std::size_t scan, std::string block) { take(scan, std::move(block)); });
      lock.lock();
      // Not in the run: a whole replay has not given it.
      if (wanted_ && wanted_ == at_first) blocks_.try_emplace(*std::exchange(wanted_, std::nullopt));
    } catch (const Abandoned&) {
    } catch (const std::exception& error) {
      lock.lock();
      failure_ = error.what();
      return;
    }
  }
}

bool ExplanationReplay::explained(std::size_t scan) {
  std::unique_lock lock(mutex_);
  next_ = scan;
  changed_.wait(lock, [this] { return ending_ || wanted_; });
  const bool missed = wanted_ && *wanted_ < scan && !marked_.contains(*wanted_);
  if (ending_ || missed) throw Abandoned();
  if (scan + kBefore < *wanted_ || scan > *wanted_ + kBehind) return false;
  marked_.insert(scan);
  return true;
}

void ExplanationReplay::take(std::size_t scan, std::string block) {
  const std::lock_guard lock(mutex_);
  blocks_[scan] = std::move(block);
  marked_.erase(scan);
  if (wanted_ == scan) wanted_.reset();
  while (blocks_.size() > kKept) {  // the farthest goes
    const auto last = std::prev(blocks_.end());
    blocks_.erase(scan - blocks_.begin()->first > last->first - scan ? blocks_.begin() : last);
  }
}

}  // namespace mapless::app
