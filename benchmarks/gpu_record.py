#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gathers what gpu_suite.sh left behind into OUT/record.json. Exit code 1 when a part failed. Standard library only."""
import argparse
import datetime
import json
import os
import platform
import re
import statistics
import sys
import xml.etree.ElementTree
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import compare  # noqa: E402  (next to this file)


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


def benchmarks_of(out):
    path = out / "benchmarks.json"
    if not path.exists():
        return None
    try:
        times = compare.read(path)
        failed = [compare.plain_name(b["name"]) for b in json.loads(path.read_text())["benchmarks"]
                  if b.get("error_occurred") or b.get("skipped")]
    except (ValueError, KeyError) as error:
        return {"error": f"benchmarks.json: {error}"}
    medians = {name: {"median_ms": statistics.median(v), "spread": compare.summary(v)[1], "runs": len(v)}
               for name, v in times.items()}
    return {"times": medians, "failed": sorted(set(failed))}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--commit", required=True)
    options = parser.parse_args()
    work, out = options.work, options.out
    melting = text_of(work / "melting.json")
    record = {
        "commit": options.commit,
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "device": text_of(work / "device.txt").strip(),
        "host": {"system": platform.platform(), "cores": os.cpu_count()},
        "parts": parts_of(work),
        "tests": tests_of(work),
        "sanitizer_errors": {tool: errors_of(text_of(work / f"{tool}.log"))
                             for tool in ("memcheck", "racecheck", "initcheck", "synccheck")},
        "benchmarks": benchmarks_of(out),
        "melting": json.loads(melting) if melting else None,
    }
    failed = [p["name"] for p in record["parts"] if p["result"] != "passed"]
    benchmarks = record["benchmarks"] or {}
    if benchmarks.get("failed") or benchmarks.get("error"):
        failed.append("benchmarks: " + (benchmarks.get("error") or ", ".join(benchmarks["failed"])))
    record["failed"] = failed
    record["passed"] = not failed and bool(record["parts"])
    (out / "record.json").write_text(json.dumps(record, indent=1) + "\n")
    for p in record["parts"]:
        print(f"{p['name']:12} {p['result']:10} {p['seconds']:4} s")
    for name, t in sorted(benchmarks.get("times", {}).items()):
        if name.startswith("scene/"):
            print(f"{name:36} {t['median_ms']:9.4f} ms/step, spread {t['spread']:.1%}")
    if record["melting"]:
        print(f"melted fraction: mean difference {record['melting']['mean_difference']}, largest "
              f"{record['melting']['largest_difference']}")
    print("passed" if record["passed"] else "FAILED: " + ("; ".join(failed) or "nothing ran"))
    return 0 if record["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
