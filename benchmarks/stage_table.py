#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/performance.md, from a record of gpu_suite.sh. Standard library only.

  stage_table.py RECORD [--docs docs/performance.md]

RECORD is a file as record.py describes it, or a folder with benchmarks.json and, where ncu may read the GPU's counters,
profile_<scene>_<particles>.csv for each scene that was profiled. Prints markdown; --docs puts it between that file's
markers. What was not measured is left out and said so.
"""
import argparse
import re
import statistics
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import compare  # noqa: E402  (next to this file)
import ncu_csv  # noqa: E402
import record  # noqa: E402
import stage_kernels  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
MARKERS = ("<!-- begin: benchmarks/stage_table.py -->", "<!-- end: benchmarks/stage_table.py -->")
# Table 2, GTX 690: ms per 5 ms step.
TABLE_2 = {"table2_35k_5k": ("35k liquid + 5k solid", 22.5), "table2_48.5k_12k": ("48.5k + 12k", 35.7),
           "table2_40.5k_20k": ("40.5k + 20k", 42.3)}


def digits(value):
    """Three that count."""
    return "" if value is None else f"{value:.3g}" if value < 1000 else f"{value:,.0f}"


def count(n):
    return f"{int(n):,}"


def title(key):
    """(60500, "2d") -> text"""
    particles, what = key
    return (f"{count(particles)}, {'2' if what == '2d' else '2.5'} dx" + (", double" if what == "double" else ""))


def markdown(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


# --- what was measured --------------------------------------------------------------------------------------------------
def measured(path):
    """name -> {"ms": median, "spread": ..., and the counters' medians}"""
    runs = {}
    for run in compare.runs_of(path):
        runs.setdefault(compare.plain_name(run["name"]), []).append(run)
    result = {}
    for name, all_runs in runs.items():
        ms = [r["real_time"] * compare.TO_MS[r["time_unit"]] for r in all_runs]
        entry = {"ms": statistics.median(ms), "low": min(ms), "high": max(ms), "runs": len(ms)}
        for counter in ("bytes", "bytes/s", "substeps", "solid", "heat_stages", "bytes_per_particle"):
            values = [r[counter] for r in all_runs if counter in r]
            if values:
                entry[counter] = statistics.median(values)
        if "bytes/s" in entry:
            entry.setdefault("bytes", entry["bytes/s"] * entry["ms"] * 1e-3)
            del entry["bytes/s"]
        result[name] = entry
    return result


def stages_of(times, backend):
    """(particles, what) -> stage -> entry"""
    tables = {}
    for name, entry in times.items():
        match = re.fullmatch(rf"stage/([\w.]+)/{backend}/(\d+)(?:/(2d|double))?", name)
        if match:
            tables.setdefault((int(match[2]), match[3] or ""), {})[match[1]] = entry
    return tables


def scenes_of(times):
    """(scene, particles, what) -> backend -> entry"""
    tables = {}
    for name, entry in times.items():
        match = re.fullmatch(r"scene/([a-z]+)(?:_(2d|double))?/(\w+)/(\d+)", name)
        if match:
            tables.setdefault((match[1], int(match[4]), match[2] or ""), {})[match[3]] = entry
    return tables


# --- what ncu counted ---------------------------------------------------------------------------------------------------
def counters_of(text, kernels):
    """stage -> sums, shares weighted by time, most registers; None stands for launches of no known stage."""
    launches = ncu_csv.launches(text)
    stages = {}
    for (_, metrics), stage in zip(launches, kernels.stages_of([name for name, _ in launches])):
        stages.setdefault(stage, []).append(metrics)
    result = {}
    for stage, all_metrics in stages.items():
        def weighted(metric, rows=all_metrics):
            pairs = [(m[ncu_csv.TIME], m[metric]) for m in rows if metric in m and ncu_csv.TIME in m]
            total = sum(t for t, _ in pairs)
            return sum(t * v for t, v in pairs) / total if total > 0 else None

        def together(metric, rows=all_metrics):
            return sum(m[metric] for m in rows if metric in m) if any(metric in m for m in rows) else None

        registers = [m[ncu_csv.REGISTERS] for m in all_metrics if ncu_csv.REGISTERS in m]
        shares = {"HBM": weighted(ncu_csv.DRAM), "L2": weighted(ncu_csv.L2), "issue": weighted(ncu_csv.ISSUE)}
        known = {k: v for k, v in shares.items() if v is not None}
        result[stage] = {
            "launches": len(all_metrics), "kernel_ns": together(ncu_csv.TIME),
            "dram_bytes": together(ncu_csv.DRAM_BYTES), "l2_bytes": together(ncu_csv.L2_BYTES),
            "share": shares, "l1_share": weighted(ncu_csv.L1), "bound": max(known, key=known.get) if known else None,
            "registers": int(max(registers)) if registers else None, "occupancy": weighted(ncu_csv.OCCUPANCY)}
    return result


def profiles_of(folder, kernels):
    """(scene, particles, what) -> counters, and -> why there are none"""
    counted, refused = {}, {}
    for path in sorted(folder.glob("profile_*.csv")):
        match = re.fullmatch(r"profile_([a-z]+)(?:_([a-z0-9]+))?_(\d+)", path.stem)
        if not match:
            continue
        key = (match[1], int(match[3]), match[2] or "")
        text = path.read_text(encoding="utf-8", errors="replace")
        counters = counters_of(text, kernels)
        if counters:
            counted[key] = counters
        else:
            refused[key] = ncu_csv.refusal(text) or "ncu wrote no table"
    return counted, refused


# --- tables -------------------------------------------------------------------------------------------------------------
def scene_table(times):
    rows = []
    for (scene, particles, what), backends in sorted(scenes_of(times).items(), key=lambda i: (i[0][0] != "water", i[0])):
        gpu, cpu = backends.get("cuda"), backends.get("cpu")
        rows.append([f"{scene}, {title((particles, what))}", digits(cpu and cpu["ms"]), digits(gpu and gpu["ms"]),
                     digits(gpu and particles / gpu["ms"] / 1e3),
                     digits((gpu or cpu).get("bytes_per_particle"))])
    return markdown(["scene", "CPU [ms]", "GPU [ms]", "GPU [million particles/s]", "bytes per particle"],
                    rows) if rows else ""


def stage_table(times, order):
    columns = [("CPU " + title(k), table) for k, table in sorted(stages_of(times, "cpu").items()) if k[0] > 50000]
    columns += [("GPU " + title(k), table) for k, table in sorted(stages_of(times, "cuda").items())]
    rows = []
    for stage in order:
        cells = [digits(table[stage]["ms"]) if stage in table else "" for _, table in columns]
        if any(cells):
            rows.append([stage, *cells])
    return markdown(["stage", *(name for name, _ in columns)], rows) if columns else ""


LAYOUTS = {"pool": "a pool at rest", "slosh": "a pool that sloshes", "droplets": "two droplets 1000 H apart, unbounded"}


def search_table(times):
    """Structures that find neighbours, side by side: ms of the search itself, of the density pass, of the sub-step."""
    found = {}
    for name, entry in times.items():
        match = re.fullmatch(r"scene/water_(\w+?)_(grid|tree)/(\w+)/(\d+)", name)
        if match:
            found.setdefault((match[1], int(match[4]), match[2]), {}).setdefault(match[3], {})["step"] = entry["ms"]
        match = re.fullmatch(r"stage/([\w.]+)/(\w+)/(\d+)/(\w+?)_(grid|tree)", name)
        if match:
            row = found.setdefault((match[4], int(match[3]), match[5]), {}).setdefault(match[2], {})
            kind = "search" if match[1].startswith("spatial.") else "density"
            row[kind] = row.get(kind, 0.0) + entry["ms"]
    rows = []
    for (layout, particles, search), row in sorted(found.items(), key=lambda i: (list(LAYOUTS).index(i[0][0]), i[0][1:])):
        cells = [digits(row.get(backend, {}).get(kind)) for backend in ("cpu", "cuda") for kind in ("search", "density", "step")]
        rows.append([f"{LAYOUTS[layout]}, {count(particles)}", search, *cells])
    return markdown(["scene", "structure", "CPU search", "CPU density", "CPU sub-step", "GPU search", "GPU density",
                     "GPU sub-step"], rows) if rows else ""


def width_table(times):
    """Regions of half-width w: ms of the stages that walk them, of the sub-step, and bytes per particle."""
    stages = ("lsm.regions", "lsm.goals", "topology.regions")
    found = {}
    for name, entry in times.items():
        match = re.fullmatch(r"scene/melting(?:_w(\d))?/(\w+)/(\d+)", name)
        if match:
            row = found.setdefault((int(match[3]), int(match[1] or 2)), {}).setdefault(match[2], {})
            row["step"], row["bytes"] = entry["ms"], entry.get("bytes_per_particle")
        match = re.fullmatch(r"stage/([\w.]+)/(\w+)/(\d+)(?:/w(\d))?", name)
        if match and match[1] in stages:
            found.setdefault((int(match[3]), int(match[4] or 2)), {}).setdefault(match[2], {})[match[1]] = entry["ms"]
    sizes = {size for size, width in found if width != 2}
    rows = []
    for (size, width), row in sorted(found.items()):
        if size not in sizes:
            continue
        cells = [digits(row.get(b, {}).get(kind)) for b in ("cpu", "cuda") for kind in (*stages, "step")]
        rows.append([count(size), str(width), *cells, digits((row.get("cuda") or row.get("cpu", {})).get("bytes"))])
    return markdown(["particles", "w", *(f"{b} {kind}" for b in ("CPU", "GPU") for kind in (*stages, "sub-step")),
                     "bytes per particle"], rows) if rows else ""


def counter_table(key, counters, times, order):
    scene, particles, what = key
    measured_stages = stages_of(times, "cuda").get((particles, what), {}) if scene == "melting" else {}
    rows = []
    for stage in [*order, None]:
        c = counters.get(stage)
        if not c:
            continue
        m = measured_stages.get(stage, {})
        shares = [digits(c["share"][k]) for k in ("HBM", "L2", "issue")]
        rows.append([stage or "(not told apart)", digits(m.get("ms")), digits(c["kernel_ns"] and c["kernel_ns"] * 1e-6),
                     str(c["launches"]), digits(m.get("bytes") and m["bytes"] * 1e-6),
                     digits(c["dram_bytes"] * 1e-6 if c["dram_bytes"] is not None else None), *shares,
                     c["bound"] or "", str(c["registers"] or ""), digits(c["occupancy"])])
    head = ["stage", "ms", "ms in kernels", "launches", "model MB", "HBM MB", "HBM %", "L2 %", "issue %", "bound",
            "registers", "occupancy %"]
    return markdown(head, rows)


def paper_tables(times):
    rows, sweep = [], []
    for name, entry in times.items():
        match = re.fullmatch(r"paper/([\w.]+)/(\w+)/(\d+)", name)
        if not match:
            continue
        substeps = entry.get("substeps") or 1
        cells = [match[2].replace("cuda", "GPU").replace("cpu", "CPU"), digits(entry["ms"]), digits(substeps),
                 digits(entry["ms"] / substeps)]
        if match[1] in TABLE_2:
            text, paper = TABLE_2[match[1]]
            rows.append([text, digits(paper), *cells, digits(paper / entry["ms"])])
        elif match[1] == "fig7":
            sweep.append((int(match[3]), [count(match[3]), *cells[1:]]))
    text = ""
    if rows:
        text += ("Table 2, the time of one step of 5 ms; the paper's on a GTX 690, in one step, ours in the sub-steps "
                 "that its sound speed needs:\n\n")
        text += markdown(["particles", "paper [ms]", "ours on", "ms", "sub-steps", "ms per sub-step", "times faster"],
                         sorted(rows)) + "\n"
    if sweep:
        text += ("\nFig. 7's sizes (a third solid) on the GPU; the paper prints a curve without numbers, and 42.3 ms at "
                 "60.5k:\n\n")
        text += markdown(["particles", "ms per 5 ms", "sub-steps", "ms per sub-step"], [r for _, r in sorted(sweep)]) + "\n"
    return text


def thread_table(times):
    found = {}
    for name, entry in times.items():
        match = re.fullmatch(r"threads/([a-z]+)(?:_(\w+))?/cpu/(\d+)/(\d+)", name)
        if match:
            found.setdefault((match[1], int(match[3]), match[2] or ""), {})[int(match[4])] = entry["ms"]
    threads = sorted({t for row in found.values() for t in row})
    rows = []
    for (scene, particles, what), row in found.items():
        one = row.get(1)
        rows.append([f"{scene}, {title((particles, what))}"] + [
            digits(row.get(t)) + (f" ({one / row[t]:.1f}x)" if one and t in row and t > 1 else "") for t in threads])
    return markdown(["scene", *(f"{t} thread{'s' if t > 1 else ''}" for t in threads)], rows) if rows else ""


def run_table(runs):
    """Whole runs of the program (whole_run.py): all of a run but start-up and final pictures over its bare sub-steps."""
    rows = []
    for run in runs:
        if run["run"].count("/") != 4:
            continue  # of another program
        _, scene, backend, _, what = run["run"].split("/")
        rows.append([f"{scene}, {count(run['particles'])}, {what}", backend, count(run["substeps"]),
                     digits(run["bare_substep_ms"]), digits(run["job_s"]), f"{run['ratio']:.2f}",
                     *(digits(run[k]) for k in ("start_up_s", "stepping_s", "reading_s", "writing_s", "pictures_s"))])
    if not rows:
        return ""
    return markdown(["run", "backend", "sub-steps", "bare sub-step [ms]", "run [s]", "run / bare", "start-up [s]",
                     "stepping [s]", "reading [s]", "writing [s]", "pictures [s]"], rows)


def report(name, about, times, counted, refused, order, runs=()):
    parts = [f"Of `{name}`: {about.get('device', 'device unknown')}, {about.get('host', {}).get('cores', '?')} CPU "
             f"threads, commit {about.get('commit', 'unknown')[:7]}. Medians; ms per sub-step."]
    missing = "Not measured in this record."
    parts += ["### Whole sub-steps", scene_table(times) or missing]
    parts += ["### Whole runs", "25 frames a second, files and probes of the scene (`default`), no files (`none`), no probes, eight "
              "gauges at 1 kHz, a thousand points in every sub-step. `run`: all but start-up and final pictures; reading and "
              "writing: what the host waits for.", run_table(runs) or missing]
    paper = paper_tables(times)
    parts += ["### The paper's sizes", paper.rstrip() or missing]
    parts += ["### Stages of the melting sub-step [ms]", stage_table(times, order) or missing]
    parts += ["### What bounds the stages"]
    if counted:
        parts.append("From ncu, one sub-step. Model: every channel the stage names, once for reading and once for writing. "
                     "Shares of the peak, over the time in kernels; the largest names the bound, and where none is "
                     "near 100 the stage waits for latency.")
    else:
        parts.append("Not in this record: no counters of ncu.")
    for key, counters in counted.items():
        parts += [f"{key[0]}, {title(key[1:])}:", counter_table(key, counters, times, order)]
    for key, why in refused.items():
        parts.append(f"{key[0]}, {title(key[1:])}: no counters: {why}.")
    parts += ["### Ways to find neighbours [ms]", search_table(times) or missing]
    parts += ["### Regions of half-width w [ms]", width_table(times) or missing]
    parts += ["### CPU threads [ms per sub-step]", thread_table(times) or missing]
    return "\n\n".join(parts) + "\n"


def put(docs, text):
    page = docs.read_text(encoding="utf-8")
    begin, end = (page.find(m) for m in MARKERS)
    if begin < 0 or end < begin:
        raise ValueError(f"{docs}: no markers {MARKERS[0]} ... {MARKERS[1]}")
    docs.write_text(page[:begin + len(MARKERS[0])] + "\n" + text + page[end:], encoding="utf-8")


def key_of(scene):
    """"melting/1000000/2d" -> ("melting", 1000000, "2d"), as profiles_of() has it"""
    name, particles, *what = scene.split("/")
    return name, int(particles), what[0] if what else ""


def scene_of(key):
    return "/".join(str(k) for k in key if k != "")


def load(path, kernels):
    """(about, times, counters, refused, runs) of a record, or of the folder that one is made from."""
    if path.is_dir():
        counted, refused = profiles_of(path, kernels)
        return {}, measured(path / "benchmarks.json"), counted, refused, []
    about, times, counters, refused, runs = record.read(path)
    return (about, times, {key_of(s): c for s, c in counters.items()}, {key_of(s): w for s, w in refused.items()}, runs)


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("record", type=Path)
    parser.add_argument("--docs", type=Path, default=None)
    options = parser.parse_args(arguments)
    kernels = stage_kernels.Kernels(ROOT)
    try:
        about, times, counted, refused, runs = load(options.record.resolve(), kernels)
    except (OSError, ValueError, KeyError) as error:
        print(f"{options.record}: {error}")
        return 1
    text = report(options.record.resolve().stem, about, times, counted, refused, kernels.order, runs)
    print(text, end="")
    if options.docs:
        put(options.docs, text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
