// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "command_line.hpp"
#include "failure.hpp"
#include "memory.hpp"

int main(int argc, char** argv) {
  runner::keep_freed_memory();
  try {
    return runner::run_command_line(argc, argv);
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
