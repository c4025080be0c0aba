# shellcheck shell=bash disable=SC2034  # the arrays are for those that source this
# SPDX-License-Identifier: Apache-2.0
# Sourced by examples/run_ice_block.sh, tests/run_all.sh, docs/build.sh and .ci/run: packages, configure, build. Never asks.
# Debian 12 and Ubuntu 24.04; elsewhere it checks nothing and leaves the packages to you.

meltsim_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

meltsim_say() { printf '\n== %s\n' "$*"; }

# meltsim_install_packages PACKAGE...: installs those that are missing, as root or through sudo.
meltsim_install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    meltsim_say "not Debian or Ubuntu: install the equivalents of: $*"
    return 0
  fi
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  meltsim_say "installing ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    # -n: fail rather than wait for a password nobody can type.
    if ! command -v sudo >/dev/null || ! { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
      echo "cannot become root. Install the packages yourself and start again:" >&2
      echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
      return 1
    fi
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
}

meltsim_build_packages=(g++ cmake ninja-build pkg-config)
meltsim_runner_packages=(libyaml-cpp-dev libcli11-dev nlohmann-json3-dev libfmt-dev libpng-dev zlib1g-dev)
# For `meltsim render` to end in a movie.
meltsim_movie_packages=(ffmpeg)
# povray and gnuplot are small; tests that need chromium, ffmpeg or python3-vtk9 say SKIPPED without them.
meltsim_test_packages=(libgtest-dev libeigen3-dev libbenchmark-dev python3 binutils povray gnuplot-nox)
# For docs/build.sh.
meltsim_docs_packages=(doxygen python3-sphinx python3-breathe python3-myst-parser furo)
# Not for the viewer: OpenGL and X11 are much to bring to a machine that may have no display, and nothing else needs
# them. Where libglfw3-dev, libimgui-dev and libepoxy-dev are, it is built; its test also wants xvfb and
# libgl1-mesa-dri, and says SKIPPED without.

# The CUDA backend is worth its build time where a GPU can run it. MELTSIM_CUDA=ON|OFF in the environment
# decides otherwise. Sets meltsim_cuda_options.
meltsim_choose_backend() {
  meltsim_cuda_options=(-DMELTSIM_CUDA=OFF)
  if [ -n "${MELTSIM_CUDA:-}" ]; then
    meltsim_cuda_options=(-DMELTSIM_CUDA="$MELTSIM_CUDA")
    return
  fi
  local nvcc
  nvcc=${CUDACXX:-$(command -v nvcc || ls /usr/local/cuda/bin/nvcc 2>/dev/null || true)}
  if ! nvidia-smi -L 2>/dev/null | grep -q '^GPU 0'; then
    meltsim_say "no NVIDIA GPU here: building for the CPU"
  elif [ -z "$nvcc" ]; then
    meltsim_say "a GPU but no nvcc: building for the CPU (install the CUDA toolkit to use the GPU)"
  else
    meltsim_say "building for the CPU and for the GPU of this machine ($nvcc)"
    export CUDACXX=$nvcc
    meltsim_cuda_options=(-DMELTSIM_CUDA=ON -DCMAKE_CUDA_ARCHITECTURES=native)
  fi
}

# Processors, but at least 2 GB of memory each: a CUDA translation unit takes that much. nproc heeds OMP_NUM_THREADS, which is about
# the threads of one program.
meltsim_jobs() {
  local processors memory
  processors=$(env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc)
  memory=$(awk '/MemAvailable/ {print int($2 / 2097152)}' /proc/meminfo)
  [ "$memory" -lt 1 ] && memory=1
  echo $((processors < memory ? processors : memory))
}

# meltsim_configure BUILD_DIR FRESH... -- OPTION...: options after FRESH only count for a new build directory;
# an existing one keeps what it was configured with, apart from the OPTIONs.
meltsim_configure() {
  local directory=$1 fresh=() options=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do fresh+=("$1"); shift; done
  [ $# -gt 0 ] && shift
  options=("$@")
  if [ -f "$directory/CMakeCache.txt" ]; then
    fresh=()
  elif command -v ninja >/dev/null; then
    fresh+=(-G Ninja)
  fi
  cmake -S "$meltsim_root" -B "$directory" "${fresh[@]}" "${options[@]}"
}

meltsim_build() { cmake --build "$1" --parallel "$(meltsim_jobs)" "${@:2}"; }
