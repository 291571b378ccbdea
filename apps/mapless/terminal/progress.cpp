#include "terminal/progress.hpp"

#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

#include "terminal/stderr.hpp"

namespace mapless::app {
namespace {

constexpr std::size_t kBarWidth = 30;

std::string clock_text(double seconds) {
  const long s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

Progress::Progress(std::string what)
    : what_(std::move(what)),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() { clear(); }

void Progress::update(std::size_t done, std::size_t total) {
  if (total == 0 || done == last_done_) return;
  if (terminal_) {
    draw_bar(done, total);
    drawn_ = true;
  } else if (const std::size_t tenth = 10 * done / total; last_done_ == 0 || tenth > last_tenth_) {
    last_tenth_ = tenth;
    say("mapless: {} of {} {} ({} %), {:.1f} {}/s\n", done, total, what_, 100 * done / total, rate(done),
        what_);
  }
  last_done_ = done;
}

void Progress::clear() {
  if (drawn_) say("\r\033[K");
  drawn_ = false;
}

double Progress::rate(std::size_t done) const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return seconds > 0 ? static_cast<double>(done) / seconds : 0;
}

void Progress::draw_bar(std::size_t done, std::size_t total) const {
  const std::size_t filled = kBarWidth * done / total;
  const double left = rate(done) > 0 ? static_cast<double>(total - done) / rate(done) : 0;
  say("\r\033[K[{:#<{}}{:.<{}}] {}/{} {}  {:.1f}/s  {} left", "", filled, "", kBarWidth - filled, done, total,
      what_, rate(done), clock_text(left));
  std::fflush(stderr);
}

}  // namespace mapless::app
