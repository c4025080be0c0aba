#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares one column of two runs' stats.csv over time. Standard library only.

  compare_runs.py A/stats.csv B/stats.csv [--column melted_fraction] [--tolerance 0.02] [--worst 0.1] [--json FILE]

Both are read as piecewise linear in time; after its end a run keeps its last value (a run that stops when all has melted
stays melted). Exit code 1 when their mean difference over time exceeds the tolerance, when they differ anywhere by
more than --worst, or when a run is empty. A splashing tank is chaotic: two roundings of one arithmetic (single and
double precision on one CPU) part by up to 6 % of a 216-particle block for a moment, and by 1 % on average.
"""
import argparse
import csv
import json
import math
import sys


def read(path, column):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [(float(r["time_s"]), float(r[column])) for r in rows]


def value_at(curve, time):
    if time <= curve[0][0]:
        return curve[0][1]
    for (t0, v0), (t1, v1) in zip(curve, curve[1:]):
        if time <= t1:
            return v0 + (v1 - v0) * ((time - t0) / (t1 - t0) if t1 > t0 else 1.0)
    return curve[-1][1]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("a")
    parser.add_argument("b")
    parser.add_argument("--column", default="melted_fraction")
    parser.add_argument("--tolerance", type=float, default=0.02)
    parser.add_argument("--worst", type=float, default=0.1)
    parser.add_argument("--json", default=None, metavar="FILE")
    options = parser.parse_args(arguments)
    try:
        a, b = read(options.a, options.column), read(options.b, options.column)
    except (OSError, KeyError, ValueError) as error:
        print(f"cannot compare: {error!r}")
        return 1
    if len(a) < 2 or len(b) < 2:
        print(f"cannot compare: {len(a)} and {len(b)} rows")
        return 1
    worst, when = 0.0, a[0][0]
    for time in sorted({t for t, _ in a} | {t for t, _ in b}):
        difference = abs(value_at(a, time) - value_at(b, time))
        if not difference <= worst:  # a NaN is the worst there is
            worst, when = difference, time
        if math.isnan(worst):
            break
    times = sorted({t for t, _ in a} | {t for t, _ in b})
    area = sum((t1 - t0) * abs(value_at(a, (t0 + t1) / 2) - value_at(b, (t0 + t1) / 2))
               for t0, t1 in zip(times, times[1:]))
    mean = area / (times[-1] - times[0])
    passed = mean <= options.tolerance and worst <= options.worst
    result = {"column": options.column, "mean_difference": None if math.isnan(mean) else mean,
              "largest_difference": None if math.isnan(worst) else worst, "at_time_s": when,
              "tolerance": options.tolerance, "rows": [len(a), len(b)], "end_time_s": [a[-1][0], b[-1][0]],
              "end_value": [a[-1][1], b[-1][1]], "passed": passed}
    print(f"{options.column}: mean difference {mean:.5f} (tolerance {options.tolerance:g}), largest {worst:.5f} at "
          f"t = {when:g} s (tolerance {options.worst:g}); "
          f"ends {a[-1][1]:g} at {a[-1][0]:g} s and {b[-1][1]:g} at {b[-1][0]:g} s")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(result, file)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
