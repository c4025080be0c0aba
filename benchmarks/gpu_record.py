#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gathers what gpu_suite.sh left behind into OUT/record.jsonl (record.py). Exit code 1 when a part failed. Standard library
only."""
import argparse
import datetime
import json
import os
import platform
import re
import sys
import xml.etree.ElementTree
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import compare  # noqa: E402  (next to this file)
import record  # noqa: E402
import stage_kernels  # noqa: E402
import stage_table  # noqa: E402


def text_of(path):
    return path.read_text(errors="replace") if path.exists() else ""


def parts_of(work):
    parts = []
    for line in text_of(work / "parts.tsv").splitlines():
        name, code, seconds = line.split("\t")
        code = int(code)
        result = {0: "passed", 124: "timed out", 137: "timed out", 125: "not run"}.get(code, "failed")
        parts.append({"name": name, "result": result, "exit_code": code, "seconds": int(seconds)})
    return parts


def tests_of(work):
    """Counts and names from CTest's or GoogleTest's XML."""
    path = work / "tests.xml"
    if not path.exists():
        return None
    try:
        cases = list(xml.etree.ElementTree.parse(path).getroot().iter("testcase"))
    except xml.etree.ElementTree.ParseError as error:
        return {"error": f"tests.xml: {error}"}
    bad = [c for c in cases if c.find("failure") is not None or c.get("status") == "fail"]
    skipped = [c for c in cases if c.find("skipped") is not None or c.get("status") == "notrun"]
    return {"run": len(cases), "failed": sorted(c.get("name", "") for c in bad if c not in skipped),
            "skipped": sorted(c.get("name", "") for c in skipped)}


def errors_of(log):
    """compute-sanitizer's own count."""
    found = re.findall(r"(?:ERROR SUMMARY: (\d+) error|RACECHECK SUMMARY: (\d+) hazard)", log)
    return sum(int(a or b) for a, b in found) if found else None


def failed_benchmarks(out):
    """Names of those that reported an error; nothing where none ran."""
    path = out / "benchmarks.json"
    if not path.exists():
        return []
    try:
        runs = json.loads(path.read_text())["benchmarks"]
    except (ValueError, KeyError) as error:
        return [f"benchmarks.json: {error}"]
    return sorted({compare.plain_name(b["name"]) for b in runs if b.get("error_occurred") or b.get("skipped")})


def measured(out):
    """(times, counters, refused) as record.write() takes them."""
    kernels = stage_kernels.Kernels(stage_table.ROOT)
    times = stage_table.measured(out / "benchmarks.json") if (out / "benchmarks.json").exists() else {}
    counted, refused = stage_table.profiles_of(out, kernels)
    return (times, {stage_table.scene_of(k): c for k, c in counted.items()},
            {stage_table.scene_of(k): w for k, w in refused.items()})


def whole_runs(out):
    return [json.loads(line) for line in text_of(out / "whole_runs.jsonl").splitlines() if line.strip()]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--commit", required=True)
    options = parser.parse_args()
    work, out = options.work, options.out
    melting = text_of(work / "melting.json")
    about = {
        "commit": options.commit,
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "device": text_of(work / "device.txt").strip(),
        "host": {"system": platform.platform(), "cores": os.cpu_count()},
        "parts": {p["name"]: p for p in parts_of(work)},
        "tests": tests_of(work),
        "sanitizer_errors": {tool: errors_of(text_of(work / f"{tool}.log"))
                             for tool in ("memcheck", "racecheck", "initcheck", "synccheck")},
        "melting": json.loads(melting) if melting else None,
    }
    failed = [name for name, p in about["parts"].items() if p["result"] != "passed"]
    bad = failed_benchmarks(out)
    if bad:
        failed.append("benchmarks: " + ", ".join(bad))
    about["failed"] = failed
    about["passed"] = not failed and bool(about["parts"])
    times, counters, refused = measured(out)
    runs = whole_runs(out)
    record.write(out / "record.jsonl", about, times, counters, refused, runs)
    for name, p in about["parts"].items():
        print(f"{name:12} {p['result']:10} {p['seconds']:4} s")
    for name, t in sorted(times.items()):
        if name.startswith("scene/"):
            print(f"{name:36} {t['ms']:9.4f} ms/step, spread {(t['high'] - t['low']) / t['ms']:.1%}")
    if about["melting"]:
        print(f"melted fraction: mean difference {about['melting']['mean_difference']}, largest "
              f"{about['melting']['largest_difference']}")
    print("passed" if about["passed"] else "FAILED: " + ("; ".join(failed) or "nothing ran"))
    return 0 if about["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
