#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# shellcheck disable=SC2317  # functions are called by name
# Everything that needs a GPU, in one go and in at most ten minutes on 16 cores:
#
#   benchmarks/gpu_suite.sh OUT_DIR
#
# builds the CUDA backend, runs the tests labelled gpu, compute-sanitizer on a small scene, random sequences of World's
# calls, the benchmarks, ncu on one step of several scenes, whole runs of the program, and ice_block and the golden hashes on
# both backends. A part that fails does not stop the others; the exit code is 1 if any did. Only the tables of
# docs/performance.md:
#
#   MELTSIM_SUITE_PARTS="build benchmarks profile" benchmarks/gpu_suite.sh OUT_DIR
#
# Writes to OUT_DIR: record.jsonl (what was run, where, with what result, and every figure: record.py; this file is what
# benchmarks/records keeps), what it is made from (benchmarks.json, profile_*.csv with ncu's counters where it may read them,
# whole_runs.jsonl), stages.md (its tables: stage_table.py), log.txt (the output of every part), stats_cpu.csv and
# stats_cuda.csv (ice_block). No network, no packages, nothing outside OUT_DIR and the build directory.
#
# Environment:
#   MELTSIM_BUILD_DIR       a build to use as it is; default: build/gpu_suite, built here
#   MELTSIM_CMAKE_ARGS      more arguments for cmake, e.g. -DCMAKE_CUDA_ARCHITECTURES=80
#   MELTSIM_SUITE_PARTS     some of "build tests memcheck racecheck initcheck synccheck fuzz benchmarks profile whole
#                           melting reproducible"
#   MELTSIM_SUITE_SECONDS   time limit of the whole (570); parts that no longer fit are reported as failed
#   MELTSIM_BENCHMARK_ARGS  more arguments for the benchmarks, e.g. --benchmark_filter=scene
#   MELTSIM_BENCHMARK_LARGE empty: leave out the scenes of ten million particles
#   MELTSIM_PROFILE_SCENES  what ncu looks at, as in benchmark names: "melting/cuda/60500 water_2d/cuda/1000000"
#   MELTSIM_COMMIT          what to record; default: what git says
set -uo pipefail

if [ $# -ne 1 ] || [ "${1#-}" != "$1" ]; then
  sed -n '4,31s/^# \{0,1\}//p' "$0"
  exit 2
fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "$1" || exit 2
out=$(cd "$1" && pwd)
build=${MELTSIM_BUILD_DIR:-$root/build/gpu_suite}
wanted=" ${MELTSIM_SUITE_PARTS:-build tests memcheck racecheck initcheck synccheck fuzz benchmarks profile whole melting reproducible} "
deadline=$((SECONDS + ${MELTSIM_SUITE_SECONDS:-570}))
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
: > "$out/log.txt"
: > "$work/parts.tsv"
# A record of an earlier run must not pass for this one's.
rm -f "$out"/record.jsonl "$out"/benchmarks.json "$out"/profile_*.csv "$out"/whole_runs.jsonl "$out"/stages.md \
  "$out"/stats_cpu.csv "$out"/stats_cuda.csv
command -v nvcc > /dev/null || PATH=$PATH:/usr/local/cuda/bin
if [ -n "${MELTSIM_BENCHMARK_LARGE-yes}" ]; then export MELTSIM_BENCHMARK_LARGE=1; else unset MELTSIM_BENCHMARK_LARGE; fi
export LD_LIBRARY_PATH=$build/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}

say() { printf '%s\n' "$*" | tee -a "$out/log.txt"; }

# part NAME LIMIT FUNCTION...: runs it for at most LIMIT seconds, notes result and duration.
part() {
  local name=$1 limit=$2 left=$((deadline - SECONDS)) start=$SECONDS code=0
  shift 2
  [[ $wanted == *" $name "* ]] || return 0
  say "== $name"
  if [ "$left" -lt 5 ]; then
    say "   not run: the time of the suite is used up"
    printf '%s\t%s\t%s\n' "$name" 125 0 >> "$work/parts.tsv"
    return 0
  fi
  [ "$limit" -lt "$left" ] || limit=$left
  timeout --kill-after=10 "$limit" bash -c '"$@"' "$name" "$@" > "$work/$name.log" 2>&1 || code=$?
  tail -c 300000 "$work/$name.log" >> "$out/log.txt"
  [ "$code" -eq 0 ] || tail -n 15 "$work/$name.log"
  case $code in
    0) say "   passed in $((SECONDS - start)) s" ;;
    124 | 137) say "   FAILED: not done after $limit s" ;;
    *) say "   FAILED with exit code $code after $((SECONDS - start)) s" ;;
  esac
  printf '%s\t%s\t%s\n' "$name" "$code" $((SECONDS - start)) >> "$work/parts.tsv"
}

build_all() {
  local generator=()
  command -v ninja > /dev/null && generator=(-G Ninja)
  # shellcheck disable=SC2086  # MELTSIM_CMAKE_ARGS holds several
  cmake -S "$root" -B "$build" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DMELTSIM_CUDA=ON -DMELTSIM_BUILD_TESTS=ON \
    -DMELTSIM_BUILD_BENCHMARKS=ON -DMELTSIM_BUILD_EXAMPLES=ON ${MELTSIM_CMAKE_ARGS:-} || return 1
  # All programs that can be built, even if one cannot.
  local target all=(meltsim_gpu_tests meltsim_gpu_world_tests meltsim_benchmarks meltsim_runner meltsim_bare_run
    meltsim_api_fuzz)
  cmake --build "$build" --parallel "$(nproc)" --target "${all[@]}" && return 0
  for target in "${all[@]}"; do
    cmake --build "$build" --parallel "$(nproc)" --target "$target"
  done
  return 1
}

gpu_tests() {
  export MELTSIM_REQUIRE_GPU=1
  local home
  home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt" 2> /dev/null)
  [ -x "$build/bin/meltsim_gpu_tests" ] || { echo "no $build/bin/meltsim_gpu_tests: built without GoogleTest?"; return 1; }
  if [ "$home" = "$root" ] && command -v ctest > /dev/null; then
    (cd "$build" && ctest -L gpu --no-tests=error --parallel 8 --output-on-failure --output-junit "$work/tests.xml")
  else  # built elsewhere: CTest's paths mean nothing here
    "$build/bin/meltsim_gpu_tests" --gtest_output="xml:$work/tests.xml" && "$build/bin/meltsim_gpu_world_tests"
  fi
}

sanitizer() {
  command -v compute-sanitizer > /dev/null || { echo "compute-sanitizer is not installed"; return 1; }
  MELTSIM_REQUIRE_GPU=1 compute-sanitizer --tool "$1" --error-exitcode 9 --print-limit 20 \
    "$build/bin/meltsim_gpu_tests" --gtest_filter='Sanitizer.*'
}

# Random sequences of calls (tests/fuzz), then a few of them under compute-sanitizer, which is some hundred times slower.
fuzz() {
  local status=0 few=(--backend cuda --cases 12 --seconds 60 --here 1)
  "$build/bin/meltsim_api_fuzz" --backend cuda --cases 1000 --seconds "${MELTSIM_FUZZ_SECONDS:-60}" --hang 20 || status=1
  command -v compute-sanitizer > /dev/null || { echo "compute-sanitizer is not installed"; return 1; }
  compute-sanitizer --error-exitcode 9 --print-limit 20 "$build/bin/meltsim_api_fuzz" "${few[@]}" ||
    status=1
  return "$status"
}

# Whole runs of the program beside its bare sub-steps.
whole() {
  python3 -B "$root/benchmarks/whole_run.py" --bin "$build/bin" --backend cuda --threads 0 --repeat 1 \
    --sizes "${MELTSIM_WHOLE_SIZES:-80000,1000000}" --out "$out/whole_runs.jsonl"
}

benchmarks() {
  # shellcheck disable=SC2086
  "$build/bin/meltsim_benchmarks" --benchmark_repetitions=3 --benchmark_out="$out/benchmarks.json" \
    --benchmark_out_format=json ${MELTSIM_BENCHMARK_ARGS:-} || return 1
  sed -i 's|"executable": ".*/|"executable": "|' "$out/benchmarks.json"  # a record says nothing of the machine's folders
}

# One sub-step per scene, between cudaProfilerStart and -Stop. Counters come from several replays of each kernel; caches are
# left as the replay before filled them, which a step of 60 thousand particles has, too. No counters are no failure: drivers
# keep them from ordinary users, and the table says so.
profile() {
  local scene file metrics run=("$build/bin/meltsim_benchmarks") said=0
  export MELTSIM_BENCHMARK_PROFILE=1
  metrics=$(cd "$root/benchmarks" && python3 -B -c 'import ncu_csv; print(",".join(ncu_csv.METRICS))') || return 1
  local options=(--profile-from-start off --csv --page raw --print-units base --cache-control none --clock-control none)
  for scene in ${MELTSIM_PROFILE_SCENES:-melting/cuda/1000000 melting/cuda/60500 melting_2d/cuda/1000000 \
    melting_double/cuda/1000000 melting_2d/cuda/60500 melting/cuda/10000000}; do
    file=$out/profile_${scene//\/cuda\//_}.csv
    if ! command -v ncu > /dev/null; then
      echo "==ERROR== ncu is not installed" | tee "$file"
      return 0
    fi
    echo "-- $scene"
    ncu "${options[@]}" --metrics "$metrics" "${run[@]}" --benchmark_filter="^profile/$scene/" > "$file" 2>&1
    # A name that this ncu does not know: the sections hold the same under the names it has.
    if grep -q 'Failed to find metric' "$file"; then
      ncu "${options[@]}" --section SpeedOfLight --section MemoryWorkloadAnalysis --section ComputeWorkloadAnalysis \
        --section LaunchStats --section Occupancy "${run[@]}" --benchmark_filter="^profile/$scene/" > "$file" 2>&1
    fi
    grep -c '^"[0-9]' "$file" || { said=1; tail -n 5 "$file"; }
    if grep -q ERR_NVGPUCTRPERM "$file"; then break; fi
  done
  [ "$said" -eq 0 ] || echo "some scenes have no counters"
  return 0
}

melting() {
  local backend runs=() status=0
  for backend in cpu cuda; do  # side by side: the one leaves the processor to the other
    "$build/bin/meltsim" run ice_block --backend "$backend" --out "$work/ice_$backend" --overwrite --export none \
      > "$work/ice_$backend.log" 2>&1 &
    runs+=($!)
  done
  # This function runs in a shell of its own; when time is up, the runs go with it.
  trap 'kill "${runs[@]}" 2> /dev/null' TERM EXIT
  wait "${runs[0]}" || status=1
  wait "${runs[1]}" || status=1
  for backend in cpu cuda; do
    echo "-- $backend"
    tail -n 20 "$work/ice_$backend.log"
    cp "$work/ice_$backend/stats.csv" "$out/stats_$backend.csv" || status=1
  done
  python3 "$root/benchmarks/compare_runs.py" "$out/stats_cpu.csv" "$out/stats_cuda.csv" \
    --json "$work/melting.json" || status=1
  return "$status"
}

# Without contraction the bodies' arithmetic is the same on both sides: the curves must be equal to the last digit.
reproducible() {
  local generator=() backend status=0 exact=$build-reproducible
  command -v ninja > /dev/null && generator=(-G Ninja)
  # shellcheck disable=SC2086
  cmake -S "$root" -B "$exact" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DMELTSIM_CUDA=ON -DMELTSIM_REPRODUCIBLE=ON \
    -DMELTSIM_BUILD_TESTS=ON -DMELTSIM_BUILD_BENCHMARKS=OFF ${MELTSIM_CMAKE_ARGS:-} || return 1
  cmake --build "$exact" --parallel "$(nproc)" --target meltsim_runner meltsim_golden meltsim_api_fuzz || return 1
  local runs=()
  for backend in cpu cuda; do  # random calls of World side by side: every state must be the same
    LD_LIBRARY_PATH=$exact/lib:$LD_LIBRARY_PATH "$exact/bin/meltsim_api_fuzz" --backend "$backend" --cases 300 --here 1 \
      --threads 1 --states "$work/states_$backend" > "$work/states_$backend.log" 2>&1 &
    runs+=($!)
  done
  wait "${runs[0]}" || status=1
  wait "${runs[1]}" || status=1
  tail -n 3 "$work/states_cpu.log" "$work/states_cuda.log"
  cmp "$work/states_cpu" "$work/states_cuda" || status=1
  for backend in cpu cuda; do
    LD_LIBRARY_PATH=$exact/lib:$LD_LIBRARY_PATH "$exact/bin/meltsim_golden" "$root/tests/golden/hashes.txt" --backend "$backend" || status=1
  done
  for backend in cpu cuda; do
    LD_LIBRARY_PATH=$exact/lib:$LD_LIBRARY_PATH "$exact/bin/meltsim" run ice_block --backend "$backend" --time 4 \
      --out "$work/exact_$backend" --overwrite --export none || status=1
  done
  for column in melted_fraction kinetic_J thermal_J momentum_y; do
    python3 "$root/benchmarks/compare_runs.py" "$work/exact_cpu/stats.csv" "$work/exact_cuda/stats.csv" \
      --column "$column" --tolerance 0 --worst 0 || status=1
  done
  return "$status"
}

# timeout(1) starts programs, not functions: these run in a bash of their own.
export root out build work
export -f build_all gpu_tests sanitizer fuzz benchmarks profile whole melting reproducible

nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader > "$work/device.txt" 2>&1 ||
  say "nvidia-smi finds no GPU: $(head -n 1 "$work/device.txt")"
if [ -z "${MELTSIM_BUILD_DIR:-}" ]; then
  part build 330 build_all
fi
part tests 200 gpu_tests
part memcheck 60 sanitizer memcheck
part racecheck 60 sanitizer racecheck
part fuzz 150 fuzz
part benchmarks 240 benchmarks
part profile 180 profile
part whole 180 whole
part melting 120 melting
part reproducible 450 reproducible
part initcheck 45 sanitizer initcheck
part synccheck 45 sanitizer synccheck

commit=${MELTSIM_COMMIT:-$(git -C "$root" rev-parse HEAD 2> /dev/null)} || commit=unknown
if [ -z "${MELTSIM_COMMIT:-}" ] && [ "$commit" != unknown ] && [ -n "$(git -C "$root" status --porcelain --untracked-files=no 2> /dev/null)" ]; then
  commit=$commit+changes
fi
python3 "$root/benchmarks/gpu_record.py" --work "$work" --out "$out" --commit "$commit"
code=$?
if [ -s "$out/benchmarks.json" ]; then
  python3 "$root/benchmarks/stage_table.py" "$out/record.jsonl" > "$out/stages.md" || code=1
  cat "$out/stages.md"
fi
say "record: $out/record.jsonl"
exit "$code"
