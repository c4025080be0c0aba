#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh machine to a picture, a movie and a page of a melting ice block: installs what is missing, builds, and runs
# the scene by way of `meltsim render`. With arguments it is `meltsim run ice_block` with them: examples/run_ice_block.sh --time 2 --out /tmp/ice
# BUILD_DIR (default build/release) is reused when it exists.
set -euo pipefail
# shellcheck source=../cmake/setup_debian.sh
source "$(dirname "${BASH_SOURCE[0]}")/../cmake/setup_debian.sh"

build=${BUILD_DIR:-$meltsim_root/build/release}
meltsim_install_packages "${meltsim_build_packages[@]}" "${meltsim_runner_packages[@]}"
meltsim_choose_backend
meltsim_configure "$build" -DCMAKE_BUILD_TYPE=Release "${meltsim_cuda_options[@]}" \
  -DMELTSIM_BUILD_TESTS=OFF -DMELTSIM_BUILD_BENCHMARKS=OFF -- \
  -DMELTSIM_BUILD_EXAMPLES=ON -DMELTSIM_BUILD_RUNNER=ON
meltsim_build "$build" --target meltsim_runner

if [ $# -gt 0 ]; then
  command=(run ice_block "$@")
else  # without POV-Ray, which takes several times as long and which a fresh machine has not
  # Without it there are pictures, a page and no movie.
  meltsim_install_packages "${meltsim_movie_packages[@]}" || meltsim_say "no ffmpeg: there will be no movie"
  command=(render ice_block --fps 10 --pictures 0 --size 800x450 --samples 2 --renderer builtin)
fi
meltsim_say "$build/bin/meltsim ${command[*]}"
"$build/bin/meltsim" "${command[@]}"
meltsim_say "to type \`meltsim\` in this shell: export PATH=\"$(cd "$build/bin" && pwd):\$PATH\""
