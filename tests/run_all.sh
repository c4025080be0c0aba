#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh machine to a test report: installs what is missing, builds everything, runs every test.
# Arguments go to ctest, e.g.  tests/run_all.sh -R physics
# MELTSIM_PYTHON=python3 in the environment builds and tests the Python package too, where that Python has nanobind.
# BUILD_DIR (default build/release) is reused when it exists; MELTSIM_CMAKE_ARGS is more for CMake to configure it with.
set -euo pipefail
# shellcheck source=../cmake/setup_debian.sh
source "$(dirname "${BASH_SOURCE[0]}")/../cmake/setup_debian.sh"

build=${BUILD_DIR:-$meltsim_root/build/release}
meltsim_install_packages "${meltsim_build_packages[@]}" "${meltsim_runner_packages[@]}" "${meltsim_test_packages[@]}"
meltsim_choose_backend
# shellcheck disable=SC2086  # MELTSIM_CMAKE_ARGS holds several
meltsim_configure "$build" -DCMAKE_BUILD_TYPE=Release "${meltsim_cuda_options[@]}" -- ${MELTSIM_CMAKE_ARGS:-} \
  -DMELTSIM_BUILD_EXAMPLES=ON -DMELTSIM_BUILD_RUNNER=ON -DMELTSIM_BUILD_TESTS=ON ${MELTSIM_PYTHON:+-DMELTSIM_BUILD_PYTHON=AUTO "-DPython_EXECUTABLE=$MELTSIM_PYTHON"}
meltsim_build "$build"

meltsim_say "ctest"
status=0
(cd "$build" && ctest --output-on-failure --parallel "$(meltsim_jobs)" "$@") || status=$?
if [ "$status" -eq 0 ]; then
  meltsim_say "tests passed (backends: $(grep -q '^CMAKE_CUDA_COMPILER:.*=/' "$build/CMakeCache.txt" && echo 'cpu, cuda' || echo cpu))"
else
  meltsim_say "tests FAILED; again, only those: (cd $build && ctest --rerun-failed --output-on-failure)"
fi
exit "$status"
