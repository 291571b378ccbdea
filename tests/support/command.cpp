#include "support/command.hpp"

#include <array>
#include <csignal>
#include <optional>
#include <stdexcept>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/paths.hpp"

namespace mapless::test {
namespace {

struct Pipe {
  int read_end = -1;
  int write_end = -1;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
  return {ends[0], ends[1]};
}

std::optional<std::string> read_line(std::FILE* stream) {
  std::string line;
  for (int c = 0; (c = std::fgetc(stream)) != EOF;) {
    line += static_cast<char>(c);
    if (c == '\n') return line;
  }
  return line.empty() ? std::nullopt : std::optional(line);
}

std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t count = 0; (count = read(descriptor, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(descriptor);
  return text;
}

pid_t spawn(const std::vector<std::string>& arguments, int out, int err) {
  std::vector<std::string> words = {built_command()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  // Signals act as at a terminal, even if the tests run under nohup or as a background job.
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t process = -1;
  const int error = posix_spawn(&process, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + words.front());
  return process;
}

}  // namespace

RunningCommand::RunningCommand(const std::vector<std::string>& arguments) {
  const Pipe out = make_pipe(), err = make_pipe();
  process_ = spawn(arguments, out.write_end, err.write_end);
  close(out.write_end);
  close(err.write_end);
  error_stream_ = File(fdopen(err.read_end, "r"), &std::fclose);
  out_ = std::async(std::launch::async, read_all, out.read_end);
}

RunningCommand::~RunningCommand() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

bool RunningCommand::wait_for_error_line(const std::string& text) {
  while (const auto line = read_line(error_stream_.get())) {
    err_ += *line;
    if (line->find(text) != std::string::npos) return true;
  }
  return false;
}

void RunningCommand::send(int signal) const { kill(process_, signal); }

CommandResult RunningCommand::wait() {
  while (const auto line = read_line(error_stream_.get())) err_ += *line;
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, out_.get(), err_};
}

CommandResult run_command(const std::vector<std::string>& arguments) {
  return RunningCommand(arguments).wait();
}

}  // namespace mapless::test
