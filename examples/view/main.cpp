// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>

#include "failure.hpp"
#include "view_options.hpp"
#include "viewer.hpp"

int main(int argc, char** argv) {
  try {
    const auto options = view::parse_view_options(argc, argv);
    return options ? view::run_viewer(*options) : 0;
  } catch (const runner::Failure& failure) {
    std::fprintf(stderr, "%s\n", failure.what());
    return static_cast<int>(failure.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "memory: the machine has no more; try a smaller --scale\n");
    return static_cast<int>(runner::ExitCode::device);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "meltsim-view: unexpected error: %s\n", error.what());
    return static_cast<int>(runner::ExitCode::io);
  }
}
