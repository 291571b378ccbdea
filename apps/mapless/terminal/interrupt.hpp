#pragma once

namespace mapless::app {

/// While it lives, SIGINT, SIGTERM and SIGHUP do not end the process but are remembered; the second of a kind
/// ends it as usual. A SIGHUP that was ignored (nohup) stays so.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] static bool requested();
  /// 128 + the number of the first signal, as a shell has it for a program that the signal ended.
  [[nodiscard]] static int exit_code();
};

}  // namespace mapless::app
