#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two records of meltsim_benchmarks side by side. Standard library only.

  compare.py BEFORE AFTER [--filter REGEX] [--threshold PERCENT]

A record is a file of benchmarks/records (record.py), or what --benchmark_out=FILE --benchmark_out_format=json
--benchmark_repetitions=N wrote. Times are medians over
the repetitions, with the fastest and the slowest as the spread. A benchmark is slower (or faster) when its median moved by
at least the threshold (5 %) and the two spreads do not overlap; a record of one repetition has no spread, so nothing of
it is ever called slower. Exit code 1 when anything is slower, 2 when there is nothing to compare.
"""
import argparse
import json
import re
import statistics
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import record as compact  # noqa: E402  (next to this file)

TO_MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


def plain_name(name):
    """Without what Google Benchmark appends: iterations, repeats, manual_time."""
    return re.sub(r"/(iterations:\d+|repeats:\d+|manual_time|real_time)", "", name)


def runs_of(path):
    """The repetitions themselves, without aggregates and failures."""
    with open(path, encoding="utf-8") as file:
        record = json.load(file)
    return [run for run in record.get("benchmarks", []) if run.get("run_type", "iteration") == "iteration"
            and not run.get("error_occurred") and not run.get("skipped")]


def read(path):
    """name -> times of its repetitions [ms]; of a compact record the lowest, the median and the highest"""
    if str(path).endswith(".jsonl"):
        return {name: [e["low"], e["ms"], e["high"]] if e.get("runs", 1) > 1 else [e["ms"]]
                for name, e in compact.read(path)[1].items()}
    times = {}
    for run in runs_of(path):
        times.setdefault(plain_name(run["name"]), []).append(run["real_time"] * TO_MS[run["time_unit"]])
    return times


def summary(values):
    median = statistics.median(values)
    return median, (max(values) - min(values)) / median if median > 0 else 0.0


def verdict(before, after, threshold):
    """"slower", "faster", or why neither. threshold in percent."""
    a, b = statistics.median(before), statistics.median(after)
    if not a > 0:
        return "no time before"
    change = 100 * (b / a - 1)
    if abs(change) < threshold:
        return ""
    if min(len(before), len(after)) < 2:
        return "one repetition"
    if max(min(before), min(after)) <= min(max(before), max(after)):
        return "within spread"
    return "slower" if change > 0 else "faster"


def text_of(values):
    median, low, high = statistics.median(values), min(values), max(values)
    scale, unit = (1e-3, "s ") if median >= 1000 else (1, "ms")
    return f"{median * scale:9.4f} {unit} [{low * scale:.4f}..{high * scale:.4f}]"


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--filter", default="", help="only names that this matches")
    parser.add_argument("--threshold", type=float, default=5.0, metavar="PERCENT")
    options = parser.parse_args(arguments)
    before, after = read(options.before), read(options.after)
    names = [n for n in before if n in after and re.search(options.filter, n)]
    if not names:
        print("no benchmark is in both records")
        return 2
    width = max(len(n) for n in names)
    print(f"{'benchmark':{width}}  {'before':>34}  {'after':>34}  after/before")
    slower = []
    for name in names:
        a, b = before[name], after[name]
        said = verdict(a, b, options.threshold)
        ratio = statistics.median(b) / statistics.median(a) if statistics.median(a) > 0 else float("nan")
        print(f"{name:{width}}  {text_of(a):>34}  {text_of(b):>34}  {ratio:6.3f}{'  ' + said if said else ''}")
        if said == "slower":
            slower.append(name)
    for only, record, other in (("before", before, after), ("after", after, before)):
        missing = [n for n in record if n not in other and re.search(options.filter, n)]
        if missing:
            print(f"only {only}: {', '.join(missing)}")
    if slower:
        print(f"slower by {options.threshold:g} % or more, beyond the spread: {', '.join(slower)}")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
