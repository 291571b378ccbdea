#include "terminal/interrupt.hpp"

#include <atomic>
#include <csignal>

#include "terminal/exit_codes.hpp"

namespace mapless::app {
namespace {

std::atomic<int> first_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "set from a signal handler");

void remember(int signal) {
  int none = 0;
  first_signal.compare_exchange_strong(none, signal);
}

bool is_ignored(int signal) {
  struct sigaction action = {};
  sigaction(signal, nullptr, &action);
  return action.sa_handler == SIG_IGN;
}

void handle(void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  if (!is_ignored(SIGHUP)) sigaction(SIGHUP, &action, nullptr);
}

}  // namespace

// SA_RESTART: a read that is under way goes on, the scan in hand is finished.
InterruptGuard::InterruptGuard() { handle(remember, static_cast<int>(SA_RESTART | SA_RESETHAND)); }
InterruptGuard::~InterruptGuard() { handle(SIG_DFL, 0); }
bool InterruptGuard::requested() { return first_signal != 0; }
int InterruptGuard::exit_code() { return kSignalBase + first_signal; }

}  // namespace mapless::app
