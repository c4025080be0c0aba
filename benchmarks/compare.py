#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two records of meltsim_benchmarks side by side. Standard library only.

  compare.py BEFORE.json AFTER.json [--filter REGEX] [--worse PERCENT]

A record is what --benchmark_out=FILE --benchmark_out_format=json wrote. Time is the median over repetitions, spread the
distance from the fastest to the slowest over that median; a ratio within the spreads says nothing. With --worse the exit
code is 1 when a benchmark got slower by more than PERCENT and by more than both spreads.
"""
import argparse
import json
import re
import statistics
import sys

TO_MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


def plain_name(name):
    """Without what Google Benchmark appends: iterations, repeats, manual_time."""
    return re.sub(r"/(iterations:\d+|repeats:\d+|manual_time|real_time)", "", name)


def read(path):
    """name -> times of its repetitions [ms]"""
    with open(path, encoding="utf-8") as file:
        record = json.load(file)
    times = {}
    for run in record.get("benchmarks", []):
        if run.get("run_type", "iteration") != "iteration" or run.get("error_occurred") or run.get("skipped"):
            continue
        times.setdefault(plain_name(run["name"]), []).append(run["real_time"] * TO_MS[run["time_unit"]])
    return times


def summary(values):
    median = statistics.median(values)
    return median, (max(values) - min(values)) / median if median > 0 else 0.0


def text_of(ms):
    return f"{ms:10.4f} ms" if ms < 1000 else f"{ms / 1000:10.4f} s "


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--filter", default="", help="only names that this matches")
    parser.add_argument("--worse", type=float, default=None, metavar="PERCENT")
    options = parser.parse_args(arguments)
    before, after = read(options.before), read(options.after)
    names = [n for n in before if n in after and re.search(options.filter, n)]
    if not names:
        print("no benchmark is in both records")
        return 2
    width = max(len(n) for n in names)
    print(f"{'benchmark':{width}}  {'before':>13} spread  {'after':>13} spread  after/before")
    slower = []
    for name in names:
        (a, spread_a), (b, spread_b) = summary(before[name]), summary(after[name])
        ratio = b / a if a > 0 else float("nan")
        noise = max(spread_a, spread_b)
        sure = abs(ratio - 1) > noise
        print(f"{name:{width}}  {text_of(a)} {spread_a:6.1%}  {text_of(b)} {spread_b:6.1%}  {ratio:6.3f}"
              f"{'' if sure else '  (within spread)'}")
        if options.worse is not None and sure and ratio > 1 + options.worse / 100:
            slower.append(name)
    for only, record, other in (("before", before, after), ("after", after, before)):
        missing = [n for n in record if n not in other and re.search(options.filter, n)]
        if missing:
            print(f"only {only}: {', '.join(missing)}")
    if slower:
        print(f"slower by more than {options.worse:g} %: {', '.join(slower)}")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
