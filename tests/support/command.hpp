#pragma once

#include <cstdio>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

namespace mapless::test {

struct CommandResult {
  int exit_code = -1;  ///< -1 where a signal ended it
  std::string out;
  std::string err;
};

/// The built command `mapless`, running. Its stdout and stderr are read as they come.
class RunningCommand {
 public:
  explicit RunningCommand(const std::vector<std::string>& arguments);
  ~RunningCommand();
  RunningCommand(const RunningCommand&) = delete;
  RunningCommand& operator=(const RunningCommand&) = delete;

  /// Waits for the next line of stderr that contains `text`; false where stderr ends before.
  bool wait_for_error_line(const std::string& text);
  void send(int signal) const;
  /// Waits for its end.
  CommandResult wait();

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

  pid_t process_ = -1;
  File error_stream_{nullptr, nullptr};
  std::future<std::string> out_;
  std::string err_;
};

/// Runs the command to its end.
[[nodiscard]] CommandResult run_command(const std::vector<std::string>& arguments);

}  // namespace mapless::test
