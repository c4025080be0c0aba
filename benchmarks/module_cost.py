#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What modules cost scenes that do not need them. Standard library only.

  module_cost.py build REPOSITORY OUT [--cuda] [--jobs 2] [--only viscosity,...] [--architectures 90-real]
  module_cost.py run NAME BEFORE AFTER [NAME BEFORE AFTER ...] [--rounds 7] [--json FILE] [options of module_cost.cpp]
  module_cost.py run DIRECTORY ...

`build` makes module_cost.cpp of the commit that brought each module and of the one before it (git worktree): OUT/programs/
NAME-before and NAME-after. `run` takes such pairs, or a directory of them, and runs each in turn, before, after, after, before,
...; a round is one run of each. The table has the ratios of neighbours in time, after over before: their median, and from the
smallest to the largest, and for the processor's time the ratio of the quickest run of each, which other programs on the machine
disturb least; a pair of the same program says what the machine makes of nothing. --scenes and --particles take lists.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

# The commits that brought what runs on particles, its stages and its fields: before, after. Later ones changed them, and what
# else there was. (What viscosity's stands on, and the first of tension, do not compile by themselves.)
MODULES = {"viscosity": ("8d74f4b516", "330912093c"), "species": ("d078e88149^", "d078e88149"),
           "tension": ("3db2a4d28b^", "b1aa88aeb4"), "fields": ("a557a6023f^", "a557a6023f"),
           "isotropic": ("d59a4834d3^", "d59a4834d3"), "inlets": ("56017563f8^", "56017563f8")}

PROJECT = """cmake_minimum_required(VERSION 3.18)
project(module_cost LANGUAGES CXX)
add_subdirectory(${MELTSIM_SOURCE} meltsim EXCLUDE_FROM_ALL)
add_executable(module_cost ${PROGRAM})
target_link_libraries(module_cost PRIVATE meltsim::meltsim)
"""


def command(words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in words)}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def build(options):
    out, program = Path(options.out).resolve(), Path(__file__).resolve().with_name("module_cost.cpp")
    for directory in ("project", "programs"):
        (out / directory).mkdir(parents=True, exist_ok=True)
    (out / "project" / "CMakeLists.txt").write_text(PROJECT)
    for name in options.only.split(",") if options.only else MODULES:
        for side, commit in zip(("before", "after"), MODULES[name]):
            source, tree = out / f"{name}-{side}" / "source", out / f"{name}-{side}" / "build"
            if not source.exists():
                command(["git", "-C", options.repository, "worktree", "add", "--detach", source, commit])
            command(["cmake", "-S", out / "project", "-B", tree, f"-DMELTSIM_SOURCE={source}", f"-DPROGRAM={program}",
                     "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_SHARED_LIBS=OFF", f"-DMELTSIM_CUDA={'ON' if options.cuda else 'OFF'}",
                     "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON", f"-DCMAKE_CUDA_ARCHITECTURES={options.architectures}"])
            command(["cmake", "--build", tree, "--target", "module_cost", "--parallel", options.jobs])
            made = out / "programs" / f"{name}-{side}"
            made.write_bytes((tree / "module_cost").read_bytes())
            made.chmod(0o755)
            command(["strip", made])
            print(f"{made}: {made.stat().st_size / 1e6:.1f} MB", flush=True)
    return 0


def pairs_of(words):
    """[(name, before, after)]"""
    if len(words) == 1:
        names = sorted(path.name[:-len("-before")] for path in Path(words[0]).glob("*-before"))
        names = [name for name in MODULES if name in names] + [name for name in names if name not in MODULES]
        words = [word for name in names for word in (name, Path(words[0]) / f"{name}-before", Path(words[0]) / f"{name}-after")]
    if not words or len(words) % 3:
        sys.exit("run: expected NAME BEFORE AFTER, any number of times, or one directory that has NAME-before and NAME-after")
    return [(words[k], Path(words[k + 1]).resolve(), Path(words[k + 2]).resolve()) for k in range(0, len(words), 3)]


def once(program, words):
    return json.loads(command([program, *words]))


def alternate(before, after, words, rounds):
    """Runs of both, a round each, in turn."""
    runs = ([], [])
    for k in range(rounds):
        for side in ((0, 1) if k % 2 == 0 else (1, 0)):
            runs[side].append(once((before, after)[side], words))
    return runs


def spread(ratios):
    return f"{statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})"


def quickest(before, after):
    """Ratio of the least processor time, which GPUs' programs may not have."""
    least = [min(each["processor_ms"] for each in runs) for runs in (before, after)]
    return f"{least[1] / least[0]:.3f}" if least[0] > 0 else ""


def run(options):
    lines = ["| module | scene, particles | a sub-step without it [ms] | time | processor time | of the quickest | memory | "
             "same answer |", "|---|---|---:|---:|---:|---:|---:|---|"]
    records = []
    for name, before, after in pairs_of(options.programs):
        for scene in options.scenes.split(","):
            for particles in options.particles.split(","):
                words = ["--scene", scene, "--particles", particles]
                for option in ("backend", "threads", "precision", "warmup", "batches", "steps"):
                    if getattr(options, option) is not None:
                        words += [f"--{option}", getattr(options, option)]
                a, b = alternate(before, after, words, options.rounds)
                if {each["substeps"] for each in a} != {each["substeps"] for each in b}:
                    print(f"{name}, {scene}: sub-steps differ: {a[0]['substeps']} and {b[0]['substeps']}", file=sys.stderr)
                wall = [y["ms"] / x["ms"] for x, y in zip(a, b)]
                processor = [y["processor_ms"] / x["processor_ms"] for x, y in zip(a, b) if x["processor_ms"] > 0]
                lines.append(f"| {name} | `{scene}`, {a[0]['particles']} | {statistics.median(x['ms'] for x in a):.3g} | "
                             f"{spread(wall)} | {spread(processor) if processor else ''} | {quickest(a, b)} | "
                             f"{b[0]['bytes'] / a[0]['bytes']:.3f} | "
                             f"{'yes' if a[0]['kinetic_J'] == b[0]['kinetic_J'] else 'no'} |")
                print(lines[-1], flush=True)
                records.append({"module": name, "before": a, "after": b})
    if options.json:
        Path(options.json).write_text(json.dumps(records, indent=1) + "\n")
    print("\n" + "\n".join(lines))
    return 0


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    make = verbs.add_parser("build")
    make.add_argument("repository")
    make.add_argument("out")
    make.add_argument("--cuda", action="store_true")
    make.add_argument("--architectures", default="90-real")
    make.add_argument("--jobs", type=int, default=os.cpu_count())
    make.add_argument("--only", help="modules, with commas")
    measure = verbs.add_parser("run")
    measure.add_argument("programs", nargs="+", metavar="NAME BEFORE AFTER")
    measure.add_argument("--rounds", type=int, default=7)
    measure.add_argument("--scenes", default="dam_break,ice")
    measure.add_argument("--particles", default="8000")
    measure.add_argument("--json")
    for option in ("backend", "threads", "precision", "warmup", "batches", "steps"):
        measure.add_argument(f"--{option}")
    options = parser.parse_args(arguments)
    return build(options) if options.verb == "build" else run(options)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
