#pragma once

namespace mapless::app {

/// During its life the first SIGINT, SIGTERM or SIGHUP does not end the process: requested() returns true. A
/// second signal of the same kind ends the process as usual. A SIGHUP that is ignored (nohup) stays ignored.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] static bool requested();
  /// 128 + the number of the first signal, the exit code that shells report for a program ended by it.
  [[nodiscard]] static int exit_code();
};

}  // namespace mapless::app
