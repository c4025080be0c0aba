#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whole runs of the program against its bare sub-steps.

  whole_run.py --bin DIR [--backend cuda|cpu] [--sizes 5000,80000,1000000] [--scenes NAME,...] [--seconds S]
               [--repeat N] [--threads N] [--no-probes] [--out FILE]

DIR holds `meltsim` and `meltsim_bare_run` (target of the same name). Each scene is run with its default outputs and with
--export none, N times (the median by wall time counts). Beside it stands sub-steps x ms: the time of the same number of
sub-steps over the same simulated time in one go, without frames, readings or files. `ratio` is the run, less start-up and
final pictures, over that. The rows `gauges` (8 probes at 1 kHz) and `points` (1000 probes at every step) are of dam_break.

Writes one line of JSON per row (to FILE or standard output), and a table to standard error.
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

# Simulated seconds: a scene's end, 4 at most.
SCENES = {"dam_break": 2.0, "ice_block": 4.0, "bunnies_ducks": 4.0}


def particles(program, scene):
    said = subprocess.run([program, "check", scene, "--backend", "cpu"], capture_output=True, text=True,
                          check=True).stdout
    for line in said.splitlines():
        words = line.replace(",", "").split()
        if words and words[0] == "particles":
            return int(words[1]) + int(words[4])
    raise SystemExit(f"whole_run: `meltsim check {scene}` prints no particles")


def gauges():
    """As in SPHERIC 2: four heights of the liquid along dam_break's channel, four pressures at its far wall."""
    levels = [{"name": f"h{i}", "kind": "level", "at": [0.6 + 0.9 * i, 0.1, 0.4], "every": 1e-3} for i in range(4)]
    return levels + [{"name": f"p{i}", "at": [3.9, 0.1 + 0.1 * i, 0.4], "fields": ["pressure"], "every": 1e-3}
                     for i in range(4)]


def points():
    at = [[0.1 + 0.38 * i, 0.05 + 0.1 * j, 0.05 + 0.07 * k] for i in range(10) for j in range(10) for k in range(10)]
    return [{"name": f"p{i}", "at": x, "fields": ["pressure"], "every": "step"} for i, x in enumerate(at)]


class Bench:
    def __init__(self, options):
        self.options = options
        self.program = os.path.join(options.bin, "meltsim")
        self.bare_program = os.path.join(options.bin, "meltsim_bare_run")
        self.directory = tempfile.mkdtemp(prefix="whole_run_")
        self.rows = []
        self.seconds = 1.0

    def run_once(self, scene, scale, extra):
        out = os.path.join(self.directory, "run")
        shutil.rmtree(out, ignore_errors=True)
        start = time.perf_counter()
        done = subprocess.run([self.program, "run", scene, "--backend", self.options.backend, "--threads",
                               str(self.options.threads), "--scale", str(scale), "--time", str(self.seconds),
                               "--fps", "25", "--out", out, "--quiet", *extra], capture_output=True, text=True)
        wall = time.perf_counter() - start
        if done.returncode != 0:
            raise SystemExit(f"whole_run: {scene}: exit code {done.returncode}: {done.stderr.strip()}")
        with open(os.path.join(out, "run.json"), encoding="utf-8") as file:
            run = json.load(file)
        return {"process_s": wall, "final": run["final"], **run["timings"]["wall"]}

    def bare(self, scene, scale, final):
        dt = final["time_s"] / final["steps"]
        said = subprocess.run([self.bare_program, scene, str(scale), self.options.backend, str(self.options.threads),
                               repr(dt), str(final["steps"])], capture_output=True, text=True)
        if said.returncode != 0:
            raise SystemExit(f"whole_run: {scene}: bare run: {said.stderr.strip()}")
        return json.loads(said.stdout)

    def row(self, scene, size, scale, what, extra, bare=None):
        runs = sorted((self.run_once(scene, scale, extra) for _ in range(self.options.repeat)),
                      key=lambda run: run["all_s"])
        run = runs[len(runs) // 2]
        final = run["final"]
        if bare is None:
            bares = [self.bare(scene, scale, final) for _ in range(self.options.repeat)]
            bare = {**bares[0], "substep_ms": statistics.median(b["substep_ms"] for b in bares)}
        expected = 1e-3 * final["substeps"] * bare["substep_ms"]
        job = run["all_s"] - run["start_up_s"] - run["pictures_s"]
        row = {"run": f"whole_run/{scene}/{self.options.backend}/{size}/{what}", "particles": bare["particles"],
               "frames": final["frames"], "steps": final["steps"], "substeps": final["substeps"],
               "simulated_s": self.seconds, "bare_substep_ms": bare["substep_ms"], "bare_s": expected, "job_s": job, "ratio": job / expected,
               **{key: run[key] for key in ("process_s", "all_s", "start_up_s", "stepping_s", "reading_s",
                                            "surfaces_s", "writing_s", "pictures_s", "writer_busy_s")},
               "repeats": self.options.repeat, "threads": self.options.threads}
        row = {key: float(f"{value:.5g}") if isinstance(value, float) else value for key, value in row.items()}
        self.rows.append(row)
        print(json.dumps(row, separators=(",", ":")), file=self.options.out, flush=True)
        show(row)
        return bare

    def all(self):
        heading()
        for scene in self.options.scenes:
            count = particles(self.program, scene)
            for size in self.options.sizes:
                scale = round((size / count) ** (1 / 3), 4)
                short = self.options.backend == "cpu" or size > 100000
                self.seconds = self.options.seconds or (1.0 if short else SCENES[scene])
                bare = self.row(scene, size, scale, "default", [])
                self.row(scene, size, scale, "none", ["--export", "none"], bare)
                if scene == "dam_break" and self.options.probes:
                    self.row(scene, size, scale, "no_probes", ["--set", "probes=[]"], bare)
                    self.row(scene, size, scale, "gauges", ["--set", "probes=" + json.dumps(gauges())], bare)
                    self.row(scene, size, scale, "points", ["--set", "probes=" + json.dumps(points())], bare)
        shutil.rmtree(self.directory, ignore_errors=True)


COLUMNS = ("job_s", "bare_s", "start_up_s", "stepping_s", "reading_s", "surfaces_s", "writing_s", "pictures_s",
           "writer_busy_s")


def heading():
    print(f"{'run':48} {'particles':>9} {'substeps':>8} {'ms':>8} {'ratio':>6} "
          + " ".join(f"{name.replace('_s', ''):>9}" for name in COLUMNS) + "   [s]", file=sys.stderr)


def show(row):
    print(f"{row['run']:48} {row['particles']:9} {row['substeps']:8} {row['bare_substep_ms']:8.4g} "
          f"{row['ratio']:6.3f} " + " ".join(f"{row[name]:9.3f}" for name in COLUMNS), file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--backend", choices=("cuda", "cpu"), default="cpu")
    parser.add_argument("--sizes", type=lambda text: [int(n) for n in text.split(",")])
    parser.add_argument("--scenes", type=lambda text: text.split(","), default=list(SCENES))
    parser.add_argument("--seconds", type=float, help="simulated seconds of every run; default: 2 of dam_break, 4 of others; 1 on a CPU and "
                        "above 100,000 particles")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2, help="of the CPU; 0 = all")
    parser.add_argument("--no-probes", dest="probes", action="store_false")
    parser.add_argument("--out", type=argparse.FileType("w"), default=sys.stdout)
    options = parser.parse_args()
    if options.sizes is None:
        options.sizes = [5000] if options.backend == "cpu" else [5000, 80000, 1000000]
    Bench(options).all()


if __name__ == "__main__":
    main()
