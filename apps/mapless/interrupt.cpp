#include "interrupt.hpp"

#include <atomic>
#include <csignal>

namespace mapless::app {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void remember(int /*signal*/) { interrupted = true; }

void handle(void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

// SA_RESTART: a read that is under way goes on, the scan in hand is finished.
InterruptGuard::InterruptGuard() { handle(remember, static_cast<int>(SA_RESTART | SA_RESETHAND)); }
InterruptGuard::~InterruptGuard() { handle(SIG_DFL, 0); }
bool InterruptGuard::requested() { return interrupted; }

}  // namespace mapless::app
