#pragma once

namespace mapless::app {

/// While it lives, SIGINT and SIGTERM do not end the process but are remembered; the second one ends it as
/// usual.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] static bool requested();
};

}  // namespace mapless::app
