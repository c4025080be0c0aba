#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The documentation as a site, from a fresh machine: installs what is missing and builds build/docs/docs/html. Compiles nothing.
# BUILD_DIR (default build/docs) is reused when it exists.
set -euo pipefail
# shellcheck source=../cmake/setup_debian.sh
source "$(dirname "${BASH_SOURCE[0]}")/../cmake/setup_debian.sh"

build=${BUILD_DIR:-$meltsim_root/build/docs}
meltsim_install_packages "${meltsim_build_packages[@]}" "${meltsim_docs_packages[@]}"
meltsim_configure "$build" -DMELTSIM_CUDA=OFF -DMELTSIM_BUILD_EXAMPLES=OFF -DMELTSIM_BUILD_TESTS=OFF \
  -DMELTSIM_BUILD_BENCHMARKS=OFF -- -DMELTSIM_BUILD_DOCS=ON
meltsim_build "$build" --target docs
