#include "run/scan_reader.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace mapless::app {
namespace {

constexpr std::size_t kMostReadAhead = 2;

}  // namespace

ScanReader::ScanReader(Read read, std::size_t first, std::size_t count)
    : read_(std::move(read)),
      queue_(kMostReadAhead),
      wanted_(first),
      thread_([this, first, count] { run(first, count); }) {}

ScanReader::~ScanReader() { stop(); }

void ScanReader::stop() {
  queue_.abandon();
  if (thread_.joinable()) thread_.join();
}

ScanReader::Item ScanReader::read(std::size_t k) {
  const BusyTime::Measure measure(busy_);
  try {
    return {k, read_(k), nullptr};
  } catch (...) {
    return {k, {}, std::current_exception()};
  }
}

void ScanReader::run(std::size_t first, std::size_t count) {
  for (std::size_t k = first; k < first + count; k = std::max(k + 1, wanted_.load())) {
    if (!queue_.push(read(k))) return;
  }
  queue_.close();
}

InputScan ScanReader::take(std::size_t k) {
  wanted_ = k;
  while (auto item = queue_.pop()) {
    if (item->k < k) continue;
    if (item->error) std::rethrow_exception(item->error);
    return std::move(item->input);
  }
  throw std::logic_error("a scan is taken that was not to be read");
}

}  // namespace mapless::app
