// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

#include "command_line.hpp"
#include "failure.hpp"
#include "memory.hpp"

namespace {

/// Where the caller closed one of them (>&-), the first file that is opened would get its number, and what is printed would land in
/// that file.
void open_standard_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) == -1 && errno == EBADF)
      static_cast<void>(open("/dev/null", descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY));
}

/// What was printed may be the result (`meltsim list > scenes.txt`). A reader that went away (`| head`) is no fault.
int written(int code) {
  const bool lost = std::fflush(stdout) != 0;
  const int why = lost ? errno : 0;
  struct stat output {};
  const bool pipe =
      fstat(STDOUT_FILENO, &output) != 0 || S_ISFIFO(output.st_mode) || S_ISSOCK(output.st_mode);
  if (pipe || (!lost && std::ferror(stdout) == 0)) return code;
  std::fprintf(stderr, "standard output: cannot be written%s%s; text is missing from it\n", lost ? ": " : "",
               lost ? std::strerror(why) : "");
  return code == 0 ? static_cast<int>(runner::ExitCode::io) : code;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  runner::keep_freed_memory();
  try {
    return written(runner::run_command_line(argc, argv));
  } catch (const runner::Failure& failure) {
    std::fprintf(stderr, "%s\n", failure.what());
    return static_cast<int>(failure.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "memory: the machine has no more; try a smaller --scale\n");
    return static_cast<int>(runner::ExitCode::device);
  } catch (const std::length_error&) {  // a list longer than an address space
    std::fprintf(stderr, "memory: the machine has no more; try a smaller --scale\n");
    return static_cast<int>(runner::ExitCode::device);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "meltsim: unexpected error: %s\n", error.what());
    return static_cast<int>(runner::ExitCode::io);
  }
}
