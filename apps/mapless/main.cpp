#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <unistd.h>

#ifdef MAPLESS_DDS
#include "live/live.hpp"
#endif
#include "terminal/exit_codes.hpp"
#include "verbs/command.hpp"

namespace {

// A descriptor that is closed would be given to the next file that is opened, and what is printed end up in a
// result. This one is held, and writing to it fails.
void hold_standard_descriptors() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (fcntl(fd, F_GETFD) == -1 && open("/dev/null", O_RDONLY) != fd) std::_Exit(mapless::app::kFailure);
  }
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_descriptors();
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond the limit of the shell is an error of writing, not the end
#ifdef MAPLESS_DDS
  return mapless::app::run_command(argc, argv, mapless::app::add_live);
#else
  return mapless::app::run_command(argc, argv);
#endif
}
