// SPDX-License-Identifier: Apache-2.0
#include "show/programs.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "failure.hpp"
#include "files.hpp"

extern char** environ;

namespace runner {

namespace fs = std::filesystem;

Scratch::Scratch() {
  std::error_code error;
  const fs::path parent = fs::absolute(fs::temp_directory_path(error), error);
  path_ = (parent / "meltsim-XXXXXX").string();
  if (error || mkdtemp(path_.data()) == nullptr) {
    throw Failure(ExitCode::io, path_ + ": cannot be created: " + std::strerror(errno) +
                                    "; set TMPDIR to a directory that can be written to");
  }
}

Scratch::~Scratch() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void Scratch::take(const std::string& name, const std::string& to) const {
  if (std::rename(file(name).c_str(), to.c_str()) == 0) return;
  write_file(to, read_file(file(name)));  // on another file system, or not allowed: the copy says which
}

void Scratch::link(const std::string& name, const std::string& to) const {
  std::error_code error;
  fs::create_symlink(fs::absolute(to), file(name), error);
  if (error) throw Failure(ExitCode::io, file(name) + ": cannot be created: " + error.message());
}

std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream directories(path == nullptr ? "" : path);
  for (std::string directory; std::getline(directories, directory, ':');) {
    const fs::path file = fs::path(directory.empty() ? "." : directory) / name;
    std::error_code error;
    if (access(file.c_str(), X_OK) == 0) return fs::absolute(file, error).string();
  }
  return "";
}

int run_program(const std::vector<std::string>& arguments, const Scratch& scratch) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addchdir_np(&files, scratch.path().c_str());
  // No terminal: nothing asks, nothing waits for a key.
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, program_log, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  pid_t child = 0;
  const int failed = posix_spawn(&child, argv.front(), &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace runner
