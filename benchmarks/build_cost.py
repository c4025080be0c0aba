#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a build cost, from Ninja's log. Standard library only.

  build_cost.py BUILD_DIR [--top 10] [--limit SECONDS] [--json FILE]

Prints when the last step of BUILD_DIR/.ninja_log ended, the slowest translation units, and which took longer than --limit
(60); with --strict the exit code is then 1. Honest for one clean build only, without a compiler cache:

  cmake -S . -B build/cost -G Ninja -DCMAKE_BUILD_TYPE=Release -DMELTSIM_CUDA=OFF -DMELTSIM_CCACHE=OFF
  cmake --build build/cost --parallel 2 && benchmarks/build_cost.py build/cost

Ninja's times are wall clock: with more jobs than free cores every unit takes longer.
"""
import argparse
import json
import sys
from pathlib import Path


def read(text):
    """output -> seconds of its last build; and the longest any of them ended after its build began: the wall time of a
    clean build. (Ninja rewrites a log of many builds in an order of its own, so they cannot be told apart.)"""
    lines = text.splitlines()
    if not lines or not lines[0].startswith("# ninja log v"):
        raise ValueError("not a .ninja_log")
    steps, wall = {}, 0.0
    for line in lines[1:]:
        parts = line.split("\t")
        if len(parts) != 5 or line.startswith("#"):
            continue
        start, end, output = int(parts[0]), int(parts[1]), parts[3]
        steps[output] = (end - start) / 1000
        wall = max(wall, end / 1000)
    return steps, wall


def is_unit(output):
    return output.endswith((".o", ".obj"))


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--top", type=int, default=10)
    parser.add_argument("--limit", type=float, default=60.0, metavar="SECONDS")
    parser.add_argument("--strict", action="store_true", help="exit code 1 when a unit took longer than the limit")
    parser.add_argument("--json", type=Path, default=None)
    options = parser.parse_args(arguments)
    try:
        steps, wall = read((options.build / ".ninja_log").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        print(f"{options.build}: {error}; the build must be Ninja's")
        return 2
    units = sorted(((s, o) for o, s in steps.items() if is_unit(o)), reverse=True)
    over = [o for s, o in units if s > options.limit]
    print(f"{len(units)} translation units, {sum(s for s, _ in units):.0f} s together, {len(steps) - len(units)} other "
          f"steps; the last ended after {wall:.0f} s")
    for seconds, output in units[:options.top]:
        print(f"{seconds:8.1f} s  {output}")
    print(f"over {options.limit:g} s: {', '.join(over) if over else 'none'}")
    if options.json:
        options.json.write_text(json.dumps({"wall_s": wall, "units": {o: s for s, o in units}}, indent=1) + "\n")
    return 1 if options.strict and over else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
