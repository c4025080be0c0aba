# SPDX-License-Identifier: Apache-2.0
"""A record of one run of gpu_suite.sh: one text file, one JSON object a line. Standard library only.

  {"record": {...}}                      commit, date, device, host, parts, tests: the first line, once
  {"benchmark": NAME, "ms": MEDIAN, "low": ..., "high": ..., "runs": N, ...}   counters of the benchmark behind it
  {"counters": SCENE, "stage": STAGE, ...}   what ncu counted, one line a stage
  {"refused": SCENE, "why": TEXT}            a scene without counters
  {"run": NAME, ...}                         a whole run of the program (whole_run.py)
"""
import json


def rounded(value):
    """Six digits: more than any machine repeats."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    return [rounded(v) for v in value] if isinstance(value, list) else value


def write(path, about, times, counters, refused, runs=()):
    lines = [{"record": about}]
    lines += [{"benchmark": name, **entry} for name, entry in times.items()]
    lines += [{"counters": scene, "stage": stage or "?", **entry} for scene, stages in counters.items()
              for stage, entry in stages.items()]
    lines += [{"refused": scene, "why": why} for scene, why in refused.items()]
    lines += [row if "run" in row else {"run": "?", **row} for row in runs]
    with open(path, "w", encoding="utf-8") as file:
        for line in lines:
            file.write(json.dumps(rounded(line), separators=(",", ":")) + "\n")


def read(path):
    """(about, times, counters, refused, runs), as write() takes them. ValueError names the line that is none."""
    about, times, counters, refused, runs = {}, {}, {}, {}, []
    with open(path, encoding="utf-8") as file:
        for number, text in enumerate(file, 1):
            try:
                line = json.loads(text)
                kind = next(k for k in ("record", "benchmark", "counters", "refused", "run") if k in line)
            except (ValueError, TypeError, StopIteration):
                raise ValueError(f"{path}:{number}: no line of a record") from None
            if kind == "record":
                about = line["record"]
            elif kind == "run":
                runs.append(line)
            elif kind == "refused":
                refused[line["refused"]] = line["why"]
            elif kind == "benchmark":
                times[line.pop("benchmark")] = line
            else:
                stage = line.pop("stage")
                counters.setdefault(line.pop("counters"), {})[None if stage == "?" else stage] = line
    return about, times, counters, refused, runs
