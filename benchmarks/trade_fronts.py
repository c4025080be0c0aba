#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fronts of six scenes (error against time), and errors asked for against errors delivered. Standard library only.

  trade_fronts.py MELTSIM fronts OUT [--backend cpu] [--threads N] [--scale 1] [--time-limit 20]
  trade_fronts.py MELTSIM calibrate|flows OUT [--backend cpu] [--threads N] [--time-limit 20] [--total 240]
  trade_fronts.py MELTSIM grid OUT [--backend cpu] [--threads N] [--time-limit 20] [--only column,...]
  trade_fronts.py MELTSIM presets|budgets OUT [--backend cpu] [--threads N]
  trade_fronts.py MELTSIM reference OUT

`fronts` runs `meltsim trade` on dam_break, a column at rest, floating, conduction through a slab, a Stefan front and ice_block,
and writes one directory each and fronts.md, the tables of docs/trade.md. --time-limit is for each scene; all six take no more
than three times six times as long. `calibrate` asks for errors of scenes whose exact answers are known (`meltsim run
--max-error`), and writes calibration.csv, calibration.svg and a summary; it starts no run after --total seconds. `flows` does so
for scenes whose answers are not. `grid` runs five scenes with every combination of spacings, sound speeds and Courant numbers,
and says what settings for an error cost over the cheapest of these that are as accurate (grid.csv, choices.csv, grid.md).
`presets` runs six scenes at each --quality (presets.md), `budgets` three under --budget (budgets.md). `reference` draws the front
of records/dfsph-*.csv beside meltsim's (reference.svg) and runs nothing. --jobs: scenes (of `grid`: points) at once, where the
machine has a processor for each; budgets have the machine for themselves.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

WATER = "water: {density: 1000, viscosity: 0.2, conductivity: 0.6, heat_capacity: 4186}"


def column(height=0.8, end=0.6, probe=0.25):
    """Water at rest: it is not compressed, and p = rho g depth."""
    at = probe * height
    return f"""meltsim: 1
title: "A column of water {height} m high at rest"
domain: {{min: [0, 0, 0], max: [0.4, {height * 1.25}, 0.4], walls: box, no_slip: false}}
particles: {{spacing: 0.05}}
time: {{stepping: adaptive, end: {end}, fps: 25}}
heat: {{model: none}}
materials: {{{WATER}}}
fluids: [{{shape: {{box: [[0, 0, 0], [0.4, {height}, 0.4]]}}, material: water}}]
probes: [{{name: low, at: [0.2, {at}, 0.2], fields: [pressure], every: 0.01}}]
trade: {{observe: [volume, pressure@low], exact: {{pressure@low: {1000 * 9.81 * (height - at)}}}}}
output: {{export: []}}
"""


def slab(hot=100.0, at=0.5, end=1.0, length=0.4):
    """A slab at 0 degrees, one side held at `hot`, the other at 0: Fourier's series."""
    alpha, scale = 1.2e-6, 2e4

    def exact(t):
        x, fo = at, alpha * scale * t / length ** 2
        terms = sum(math.sin(n * math.pi * x) / n * math.exp(-(n * math.pi) ** 2 * fo) for n in range(1, 400))
        return hot * (1 - x) - 2 * hot / math.pi * terms

    n = 30  # frames, at which the probe is read
    points = [[k * end / n, exact(k * end / n)] for k in range(n + 1)]
    return f"""meltsim: 1
title: "A slab between two temperatures"
domain: {{min: [0, 0, 0], max: [{length}, 0.4, 0.4], walls: box}}
particles: {{spacing: 0.05}}
time: {{end: {end}, fps: {n / end}}}
solver: {{gravity: [0, 0, 0]}}
heat: {{model: enthalpy, time_scale: {scale}, walls: {{-x: {{temperature: {hot}}}, +x: {{temperature: 0}}}}}}
materials: {{stone: {{density: 2000, conductivity: 2.4, heat_capacity: 1000}}}}
bodies: [{{name: slab, fixed: true, material: stone, temperature: 0, shape: {{box: [[0, 0, 0], [{length}, 0.4, 0.4]]}}}}]
probes: [{{name: mid, at: [{at * length}, 0.2, 0.2], fields: [temperature], every: {end / n}}}]
trade: {{observe: [temperature@mid], exact: {{temperature@mid: {json.dumps(points)}}}}}
output: {{export: []}}
"""


def stefan(hot=40.0, share=0.5, end=1.0, length=0.4):
    """Ice at its melting point beside a hot wall: the front is at 2 lambda sqrt(alpha t)."""
    capacity, latent, alpha = 4186.0, 3.34e5, 0.6 / (1000 * 4186.0)
    wanted, low, high = capacity * hot / latent / math.sqrt(math.pi), 0.0, 3.0
    for _ in range(80):
        middle = (low + high) / 2
        if middle * math.exp(middle ** 2) * math.erf(middle) < wanted:
            low = middle
        else:
            high = middle
    scale = (share * length / (2 * low)) ** 2 / (alpha * end)
    points = [[k * end / 50, share * math.sqrt(k / 50)] for k in range(51)]
    return f"""meltsim: 1
title: "Ice melts at a wall of {hot} degrees"
domain: {{min: [0, 0, 0], max: [{length}, 0.4, 0.4], walls: box}}
particles: {{spacing: 0.05}}
time: {{stepping: adaptive, end: {end}, fps: 50}}
solver: {{gravity: [0, 0, 0], sound_speed: 5}}
heat: {{model: enthalpy, time_scale: {scale}, walls: {{-x: {{temperature: {hot}}}}}}}
materials:
  {WATER}
  ice: {{density: 1000, conductivity: 0.6, heat_capacity: 4186, melting_point: 0, latent_heat: {latent}, becomes: water}}
bodies: [{{name: ice, fixed: true, material: ice, temperature: 0, shape: {{box: [[0, 0, 0], [{length}, 0.4, 0.4]]}}}}]
trade: {{observe: [melted], exact: {{melted: {json.dumps(points)}}}}}
output: {{export: []}}
"""


ICE = "ice: {density: 917, conductivity: 2.2, heat_capacity: 2100, melting_point: 0, latent_heat: 3.34e5, becomes: water}"


def flow(title, domain, spacing, end, observe, contents, materials=WATER, heat="{model: none}", more="", fps=25):
    """A scene whose answer no formula gives."""
    return f"""meltsim: 1
title: "{title}"
domain: {{min: [0, 0, 0], max: {domain}, walls: box, no_slip: false}}
particles: {{spacing: {spacing}}}
time: {{stepping: adaptive, end: {end}, fps: {fps}}}
heat: {heat}
materials:
  {materials}
{contents}
{more}
trade: {{observe: [{observe}]}}
output: {{export: []}}
"""


def water(low, high, temperature=20):
    return f"  - {{shape: {{box: [{low}, {high}]}}, material: water, temperature: {temperature}}}"


def body(name, material, shape, temperature=0, more=""):
    return f"  - {{name: {name}, material: {material}, temperature: {temperature}, shape: {{{shape}}}{more}}}"


def flows():
    """Scenes that no law was made for: {name: (text, observable)}. A thousand particles, a second of one thread or less."""
    wood = WATER + "\n  wood: {density: 600}"
    warm, steel = WATER + "\n  " + ICE, WATER + "\n  steel: {density: 7800, conductivity: 40, heat_capacity: 500}"
    level = "probes: [{{name: wall, kind: level, at: [{0}, 0.05, 0.15]}}]"
    temperature = "probes: [{{name: side, at: {0}, fields: [temperature], every: 0.02}}]"
    cube = "fluids:\n" + water([0, 0, 0], [0.6, 0.3, 0.6]) + "\nbodies:\n"
    scenes = {
        "collapse_short": (flow("A column collapses in a short tank", [1.2, 0.8, 0.3], 0.05, 0.5, "front",
                                "fluids:\n" + water([0, 0, 0], [0.4, 0.6, 0.3])), "front"),
        "collapse_flat": (flow("A flat column runs along a channel", [2.0, 0.6, 0.3], 0.05, 0.6, "front",
                               "fluids:\n" + water([0, 0, 0], [0.8, 0.3, 0.3])), "front"),
        "collapse_corner": (flow("A column collapses out of a corner", [1.0, 0.8, 0.8], 0.05, 0.4, "front",
                                 "fluids:\n" + water([0, 0, 0], [0.4, 0.5, 0.4])), "front"),
        "slosh_tilted": (flow("A tank that stands askew", [1.0, 0.7, 0.3], 0.05, 1.0, "level@wall",
                              "fluids:\n" + water([0, 0, 0], [1.0, 0.4, 0.3]), more=level.format(0.1) +
                              "\nsolver: {gravity: [-1.5, -9.7, 0]}"), "level@wall"),
        "slosh_step": (flow("A step of water evens out", [1.2, 0.8, 0.3], 0.05, 0.8, "level@wall",
                            "fluids:\n" + water([0, 0, 0], [0.6, 0.5, 0.3]) + "\n" + water([0.6, 0, 0], [1.2, 0.3, 0.3]),
                            more=level.format(0.1)), "level@wall"),
        "cube_afloat": (flow("A cube floats", [0.6, 0.6, 0.6], 0.05, 1.0, "draught@cube", cube + body(
            "cube", "wood", "box: [[0.2, 0.2, 0.2], [0.4, 0.4, 0.4]]"), wood), "draught@cube"),
        "raft_afloat": (flow("A raft floats", [0.6, 0.6, 0.6], 0.05, 1.0, "draught@raft", cube + body(
            "raft", "wood", "box: [[0.15, 0.25, 0.15], [0.45, 0.4, 0.45]]", more=", density: 300"), wood), "draught@raft"),
        "cube_sinks": (flow("A cube sinks", [0.6, 0.7, 0.6], 0.05, 0.5, "path@cube", "fluids:\n" + water(
            [0, 0, 0], [0.6, 0.5, 0.6]) + "\nbodies:\n" + body("cube", "wood", "box: [[0.2, 0.3, 0.2], [0.4, 0.5, 0.4]]",
                                                             more=", density: 2000"), wood), "path@cube"),
        "ball_of_water": (flow("A ball of water falls onto a floor", [1.2, 0.6, 1.2], 0.05, 0.4, "front", "fluids:\n" +
                               "  - {shape: {sphere: {center: [0.6, 0.35, 0.6], radius: 0.2}}, material: water}"), "front"),
        "ice_in_bath": (flow("A block of ice melts in a bath", [0.6, 0.6, 0.6], 0.05, 1.2, "melted", "fluids:\n" + water(
            [0, 0, 0], [0.6, 0.35, 0.6], 60) + "\nbodies:\n" + body("ice", "ice", "box: [[0.2, 0.2, 0.2], [0.4, 0.4, 0.4]]"),
            warm, "{time_scale: 1.5e4}"), "melted"),
        "ice_ball": (flow("A ball of ice melts in a bath", [0.6, 0.6, 0.6], 0.05, 1.2, "melted", "fluids:\n" + water(
            [0, 0, 0], [0.6, 0.4, 0.6], 40) + "\nbodies:\n" + body("ice", "ice", "sphere: {center: [0.3, 0.3, 0.3], radius: 0.15}",
                                                                  -10), warm, "{time_scale: 2e4}"), "melted"),
        "ice_on_plate": (flow("A block of ice melts on a hot plate", [0.6, 0.5, 0.6], 0.05, 1.2, "melted", "bodies:\n" + body(
            "ice", "ice", "box: [[0.15, 0, 0.15], [0.45, 0.3, 0.45]]"), warm,
            "{time_scale: 2e4, walls: {-y: {temperature: 80}}}"), "melted"),
        "ball_cools": (flow("A hot ball of steel in a bath", [0.5, 0.5, 0.5], 0.05, 1.0, "temperature@side", "fluids:\n" + water(
            [0, 0, 0], [0.5, 0.4, 0.5], 20) + "\nbodies:\n" + body(
                "ball", "steel", "sphere: {center: [0.25, 0.2, 0.25], radius: 0.1}", 200, ", fixed: true"), steel,
            "{time_scale: 1e4}", temperature.format([0.25, 0.35, 0.25])), "temperature@side"),
        "bath_cools": (flow("A bath cools at a wall", [0.5, 0.5, 0.5], 0.05, 1.0, "temperature@side", "fluids:\n" + water(
            [0, 0, 0], [0.5, 0.4, 0.5], 80), WATER, "{time_scale: 4e4, walls: {-x: {temperature: 10}}}",
            temperature.format([0.15, 0.2, 0.25])), "temperature@side"),
        "collapse_wide": (flow("A wide column collapses", [1.6, 0.6, 0.5], 0.05, 0.5, "front",
                               "fluids:\n" + water([0, 0, 0], [0.6, 0.45, 0.5])), "front"),
        "slosh_deep": (flow("A deep tank that stands askew", [0.6, 0.8, 0.35], 0.05, 0.8, "level@wall",
                            "fluids:\n" + water([0, 0, 0], [0.6, 0.5, 0.35]), more=level.format(0.1) +
                            "\nsolver: {gravity: [-1, -9.75, 0]}"), "level@wall"),
        "oil_tips": (flow("Oil on water in a tank that stands askew", [1.0, 0.6, 0.3], 0.05, 0.8, "level@wall",
                          "fluids:\n" + water([0, 0, 0], [1.0, 0.2, 0.3]) + "\n  - {shape: {box: [[0, 0.2, 0], [1.0, 0.35, 0.3]]}, "
                          "material: oil}", WATER + "\n  oil: {density: 800, viscosity: 0.5}", more=level.format(0.1) +
                          "\nsolver: {gravity: [-1, -9.75, 0]}"), "level@wall"),
        "ball_afloat": (flow("A ball floats", [0.6, 0.6, 0.6], 0.05, 1.0, "draught@ball", cube + body(
            "ball", "wood", "sphere: {center: [0.3, 0.3, 0.3], radius: 0.15}", more=", density: 500"), wood), "draught@ball"),
        "ice_in_corner": (flow("Ice that is held in a corner of a bath", [0.5, 0.5, 0.5], 0.05, 1.0, "melted", "fluids:\n" + water(
            [0, 0, 0], [0.5, 0.4, 0.5], 50) + "\nbodies:\n" + body("ice", "ice", "box: [[0, 0, 0], [0.25, 0.3, 0.25]]", -5,
                                                                  ", fixed: true"), warm, "{time_scale: 2e4}"), "melted"),
        "floor_heats": (flow("A hot floor under a bath", [0.5, 0.5, 0.5], 0.05, 1.0, "temperature@side", "fluids:\n" + water(
            [0, 0, 0], [0.5, 0.4, 0.5], 10), WATER, "{time_scale: 6e4, walls: {-y: {temperature: 90}}}",
            temperature.format([0.25, 0.15, 0.25])), "temperature@side"),
    }
    return scenes


def run(arguments, **more):
    return subprocess.run([str(a) for a in arguments], capture_output=True, text=True, **more)


def machine(options):
    words = ["--backend", options.backend]
    return words + (["--threads", str(options.threads)] if options.threads else [])


def side_by_side(options, work, items):
    """What `work` returns for each item, in order, --jobs of them at once."""
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        return list(pool.map(work, items))


def fronts(options, out):
    scenes = {"dam_break": ["--time", "1"], "column": [], "floating": ["--time", "2"], "slab": [], "stefan": [],
              "ice_block": ["--time", "4"]}
    texts = {"column": column(), "slab": slab(), "stefan": stefan()}

    def front(item):
        name, more = item
        scene, lines = name, []
        if name in texts:
            scene = out / f"{name}.yaml"
            scene.write_text(texts[name])
        else:
            more = [*more, "--scale", str(options.scale)]
        begun = time.monotonic()
        done = run([options.meltsim, "trade", scene, *more, *machine(options), "--time-limit", options.time_limit, "--points", "8",
                    "--out", out / name], timeout=60 + 8 * options.time_limit)
        (out / f"{name}.txt").write_text(done.stdout + done.stderr)
        print(f"{name}: exit {done.returncode}, {time.monotonic() - begun:.0f} s", flush=True)
        if done.returncode != 0:
            return [f"### {name}", "", f"No front: {done.stderr.strip()}", ""]
        study = json.loads((out / name / "trade.json").read_text())
        with open(out / name / "front.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        first = [row for row in rows if row["observable"] == rows[0]["observable"]]
        lines += [f"### {name}: {first[0]['observable']}", "", f"{study['device']}.", "",
                  "| expected error [%] | expected time [s] | error [%] | time [s] | spacing [m] | sound speed [m/s] | Courant |",
                  "|---:|---:|---:|---:|---:|---:|---:|"]
        for row in first:
            scale = float(row["error"]) / max(float(row["error_share"]), 1e-300) or 1
            measured = row["measured_error"]
            lines.append("| {:.2g} | {:.3g} | {} | {} | {:.3g} | {:.3g} | {:.2g} |".format(
                100 * float(row["error_share"]), float(row["seconds"]),
                f"{100 * float(measured) / scale:.2g}" if measured else "", row["measured_seconds"],
                float(row["spacing"]), float(row["sound_speed"]), float(row["courant"])))
        return [*lines, ""]

    text = "\n".join(line for lines in side_by_side(options, front, scenes.items()) for line in lines)
    (out / "fronts.md").write_text(text)
    print(text)
    return 0


QUALITIES = ("draft", "balanced", "accurate")
ASKED = (0.2, 0.1, 0.05, 0.03, 0.01)


def asked_and_delivered(options, out, scene, name, of, asked):
    """A row: what `meltsim run --max-error` expected, and what it says that it delivered; its values."""
    where = out / f"{name}_{asked}"
    row = {"scene": name, "of": of, "asked": asked, "exit": "", "expected": "", "delivered": "", "estimated": "",
           "truth_known_to": "", "probes": "", "probing_s": "", "said": ""}
    try:
        done = run([options.meltsim, "run", scene, "--max-error", asked, "--of", of, "--time-limit", options.time_limit,
                    *machine(options), "--no-page", "--no-still", "--out", where], timeout=options.longest,
                   env={**os.environ, "XDG_CACHE_HOME": str(out.resolve() / "cache")})
    except subprocess.TimeoutExpired:
        return {**row, "exit": "too long"}, []
    row["exit"] = done.returncode
    row["said"] = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""
    if done.returncode != 0:
        return row, []
    trade = json.loads((where / "run.json").read_text())["trade"]
    row["expected"], row["estimated"] = trade["expected"]["share"], trade["delivered"][of]["share"]
    row["delivered"] = row["estimated"]
    row["probes"], row["probing_s"] = trade["probes"], 0 if trade["from_cache"] else trade["probing_s"]
    return row, trade["delivered"][of]["values"]


def calibrate(options, out):
    scenes = {}
    for length in (0.3, 0.4, 0.5):
        for at in (0.25, 0.5):
            for end in (0.5, 1.5):
                scenes[f"slab_{length}_{at}_{end}"] = (slab(100.0, at, end, length), "temperature@mid")
    for hot in (15.0, 60.0, 90.0):
        for share in (0.3, 0.6):
            for length in (0.4, 0.5):
                scenes[f"stefan_{hot:g}_{share}_{length}"] = (stefan(hot, share, 1.0, length), "melted")
    begun = time.monotonic()

    def ask(item):
        rows, (name, (text, of)) = [], item
        scene = out / f"{name}.yaml"
        scene.write_text(text)
        for asked in ASKED:
            if time.monotonic() - begun > options.total:
                break
            row, _ = asked_and_delivered(options, out, scene, name, of, asked)
            rows.append(row)
            print(name, asked, row["exit"], row["expected"], row["delivered"], flush=True)
        return rows

    rows = [row for rows in side_by_side(options, ask, scenes.items()) for row in rows]
    return report(rows, out, "calibration")


def truth_of(options, out, scene, name, of):
    """The observable's limit, and how well it is known: means of two starts at a spacing finer by the second of --finer; where the
    first is further away than 1 % of the scale, by the third as well, and Richardson's extrapolation over the three."""
    means, spreads, scale, (a, b, c) = [], [], 0, options.finer
    for finer in (a, b, c):
        if finer == c and largest(*means) <= 0.01 * scale:
            return means[1], max(largest(*means), spreads[1])
        where = out / f"{name}_truth_{finer:g}"
        if not (where / "ensemble.json").exists():
            done = run([options.meltsim, "trade", scene, "--scale", finer, "--ensemble", 2, *machine(options), "--out", where])
            if done.returncode != 0:
                sys.exit(f"{name}: {done.stderr.strip()}")
        result = json.loads((where / "ensemble.json").read_text())["observables"][of]
        means.append(result["mean"])
        spreads.append(result["spread"])
        scale = result["scale"]
    falls = largest(means[0], means[1]) / max(largest(means[1], means[2]), 1e-300)

    def limit(p):
        more = c ** -p / (b ** -p - c ** -p)
        return [y if x is None or y is None else y + more * (y - x) for x, y in zip(means[1], means[2])]

    def of_order(p):
        return (a ** -p - b ** -p) / (b ** -p - c ** -p)

    if falls < 1:  # scatter, not convergence
        return means[2], max(largest(means[1], means[2]), spreads[2])
    order = min((k / 100 for k in range(100, 201)), key=lambda p: abs(of_order(p) - falls))
    return limit(order), max(largest(limit(1), limit(2)), spreads[2])


def largest(a, b):
    """Largest difference; paths have three numbers per time."""
    step = 3 if len(a) == len(b) and len(a) % 3 == 0 and len(a) > 100 else 1
    apart = [math.dist(a[i:i + step], b[i:i + step]) for i in range(0, min(len(a), len(b)), step)
             if None not in a[i:i + step] and None not in b[i:i + step]]
    return max(apart, default=math.nan)


# What bodies draw once they lie still: Archimedes.
ARCHIMEDES = {"cube_afloat": 0.6 * 0.2, "raft_afloat": 0.3 * 0.15, "ball_afloat": 0.5 * 0.3}


def calibrate_flows(options, out):
    begun = time.monotonic()

    def ask(item):
        rows, (name, (text, of)) = [], item
        if time.monotonic() - begun > options.total:
            return rows
        scene = out / f"{name}.yaml"
        scene.write_text(text)
        truth, apart = ([ARCHIMEDES[name]], 0.0) if name in ARCHIMEDES else truth_of(options, out, scene, name, of)
        for asked in ASKED:
            row, values = asked_and_delivered(options, out, scene, name, of, asked)
            if values:
                trade = json.loads((out / f"{name}_{asked}" / "run.json").read_text())["trade"]["delivered"][of]
                scale = trade["error"] / trade["share"] if trade["share"] else 1
                row["delivered"], row["truth_known_to"] = largest(values, truth) / scale, apart / scale
            rows.append(row)
            print(name, asked, row["exit"], row["expected"], row["estimated"], row["delivered"], row["truth_known_to"], flush=True)
        return rows

    scenes = {name: scene for name, scene in flows().items() if not options.only or name in options.only.split(",")}
    rows = [row for rows in side_by_side(options, ask, scenes.items()) for row in rows]
    return report(rows, out, "flows")


GRID_ASKED = (0.2, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005)
# Of the grid: multiples of the sound speed, Courant numbers; longest steps [s] where only heat moves. At the two finest spacings
# the first three of the last or of the sound speeds: faster ones cost more than all others together.
GRID_SOUND, GRID_COURANT = (0.3, 0.45, 0.65, 1, 1.4, 2), (0.25, 0.4, 0.6)
GRID_STEPS = (1 / 30, 1 / 45, 1 / 60, 1 / 90, 1 / 150, 1 / 240)


def grid_scenes():
    """{name: (text, observable, spacings, coarsest first)}: three with an exact answer, two flows."""
    known, boxes = flows(), ((column(), "volume", (6, 7, 8, 9, 11, 13)), (slab(), "temperature@mid", (6, 8, 10, 14, 20, 28)),
                             (stefan(), "melted", (6, 8, 10, 12, 16, 22)))
    scenes = {name: (text, of, [0.4 / n for n in cells]) for name, (text, of, cells) in zip(("column", "slab", "stefan"), boxes)}
    scenes["collapse_corner"] = (*known["collapse_corner"], [0.1, 1 / 15, 0.05, 0.04, 1 / 30, 0.025])
    scenes["bath_cools"] = (*known["bath_cools"], [1 / 12, 1 / 16, 0.05, 1 / 24, 1 / 30, 0.025])
    return scenes


def grid_points(settings, spacings):
    """The settings of all points, cheapest first; `settings` are chosen ones that tell what the multiples refer to."""
    faster = settings["multiples"]["sound_speed"]
    points = []
    for k, spacing in enumerate(spacings):
        fine = k >= len(spacings) - 2
        if "sound_speed" not in settings:
            points += [{"spacing": spacing, "dt": dt} for dt in (GRID_STEPS[:3] if fine else GRID_STEPS)]
            continue
        sound, viscosity = settings["sound_speed"] / faster, settings["artificial_viscosity"] * max(1, faster)
        points += [{"spacing": spacing, "sound_speed": sound * m, "courant": courant, "artificial_viscosity": viscosity / max(1, m)}
                   for m in (GRID_SOUND[:3] if fine else GRID_SOUND) for courant in GRID_COURANT]
    return points


KEYS = {"spacing": "particles.spacing", "dt": "time.dt", "sound_speed": "solver.sound_speed", "courant": "solver.courant",
        "artificial_viscosity": "solver.artificial_viscosity"}


def measured(options, scene, of, where, settings, starts=2):
    """Counted work, seconds (of the quickest start) and the observable's values of each start; None where settings fail."""
    words = [word for key in KEYS if key in settings for word in ("--set", f"{KEYS[key]}={settings[key]:.9g}")]
    done = run([options.meltsim, "trade", scene, *words, "--observe", of, "--ensemble", starts, *machine(options), "--out", where])
    if done.returncode != 0:
        return None
    result = json.loads((where / "ensemble.json").read_text())
    runs, observable = result["runs"], result["observables"][of]
    if not all(each["complete"] for each in runs):
        return None
    return {"exact": None, **observable, "work": runs[0]["work"], "seconds": min(each["wall_s"] for each in runs),
            "values": [each["values"][0] for each in runs]}


def error_of(point, truth):
    """Mean over the starts of the largest error over the run, as a share of the scale."""
    return sum(largest(values, truth) for values in point["values"]) / len(point["values"]) / point["scale"]


def grid(options, out):
    """What --max-error picks beside the cheapest points of a grid."""
    scenes = {name: scene for name, scene in grid_scenes().items() if not options.only or name in options.only.split(",")}
    files = {name: out / f"{name}.yaml" for name in scenes}
    for name, file in files.items():
        file.write_text(scenes[name][0])

    def ask(name):
        return [(asked, *asked_and_delivered(options, out, files[name], name, scenes[name][1], asked)[:1]) for asked in GRID_ASKED]

    asked = dict(zip(scenes, side_by_side(options, ask, scenes)))
    jobs, choices = [], {}
    for name, rows in asked.items():
        good = [row for _, row in rows if row["exit"] == 0]
        if not good:
            sys.exit(f"{name}: no settings for any error: {rows[0][1]['said']}")
        for value, row in rows:
            if row["exit"] == 0:
                trade = json.loads((out / f"{name}_{value}" / "run.json").read_text())["trade"]
                choices[name, value] = trade["settings"]
        first = next(settings for (scene, _), settings in choices.items() if scene == name)
        _, of, spacings = scenes[name]
        if name in flows():  # the truth, and how well it is known
            jobs += [(name, ("truth", finer), {"spacing": spacings[2] / finer}) for finer in (4, 2)]
        jobs += [(name, ("grid", k), point) for k, point in enumerate(grid_points(first, spacings))]
        # Finer ones than the grid's have nothing beside them, and cost more than all of it.
        jobs += [(name, ("choice", value), choices[name, value]) for value in GRID_ASKED
                 if (name, value) in choices and choices[name, value]["spacing"] > 0.75 * spacings[-1]]
    begun = time.monotonic()

    def measure(job):
        name, (kind, number), settings = job
        return measured(options, files[name], scenes[name][1], out / f"{name}_{kind}_{number}", settings)

    jobs.sort(key=lambda job: job[2]["spacing"])  # the longest first
    results = {job[:2]: result for job, result in zip(jobs, side_by_side(options, measure, jobs))}
    settings_of = {job[:2]: job[2] for job in jobs}
    print(f"{len(jobs)} points in {time.monotonic() - begun:.0f} s", flush=True)
    return compare_with_grid(options, out, scenes, files, asked, results, settings_of)


def truth_in(results, name):
    """The truth of a scene of the grid, and what it is known to as a share of the scale."""
    finest = results.get((name, ("truth", 4)))
    if (name, ("truth", 4)) not in results:
        some = next(result for (scene, _), result in results.items() if scene == name and result)
        return some["exact"], 0.0
    if not finest or not results[name, ("truth", 2)]:
        sys.exit(f"{name}: the truth could not be computed")
    # A third: what half of the resolution differs by, where the error is of second order. The first order says all of it.
    apart = largest(finest["mean"], results[name, ("truth", 2)]["mean"])
    return finest["mean"], max(apart, finest["spread"]) / finest["scale"]


def compare_with_grid(options, out, scenes, files, asked, results, settings_of):
    points, again = [], {}
    columns = ["scene", "observable", "kind", "number", "spacing", "sound_speed", "courant", "dt", "error", "work", "seconds"]
    errors = {}
    for name, (_, of, _) in scenes.items():
        truth, apart = truth_in(results, name)
        errors[name] = {key[1]: error_of(result, truth) for key, result in results.items() if key[0] == name and result}
        print(f"{name}: the truth is known to {100 * apart:.2g} %; "
              f"{sum(key[0] == 'grid' for key in errors[name])} points of the grid", flush=True)
        for (kind, number), error in errors[name].items():
            result, settings = results[name, (kind, number)], settings_of[name, (kind, number)]
            points.append({**{key: settings.get(key, "") for key in columns}, "scene": name, "observable": of, "kind": kind,
                           "number": number, "error": error, "work": result["work"], "seconds": result["seconds"]})
    with open(out / "grid.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        writer.writerows(points)

    def alone(name, key):
        """Seconds of the quickest of three starts with nothing beside it."""
        text = json.dumps([name, {k: v for k, v in settings_of[name, key].items() if k in KEYS}])
        if text not in again:
            again[text] = measured(options, files[name], scenes[name][1], out / f"{name}_alone_{len(again)}",
                                   settings_of[name, key], 3)["seconds"]
        return again[text]

    def over(name, choice, most, coarsest=math.inf):
        """Work and seconds of a choice over those of the cheapest points whose error, and spacing, is no larger."""
        able = [key for key, error in errors[name].items()
                if key[0] == "grid" and error <= most and settings_of[name, key]["spacing"] <= coarsest]
        if not able:
            return None
        cheapest = min(able, key=lambda key: results[name, key]["work"])
        quickest = min(able, key=lambda key: results[name, key]["seconds"])
        return (results[name, choice]["work"] / results[name, cheapest]["work"],
                alone(name, choice) / min(alone(name, cheapest), alone(name, quickest)), cheapest)

    kinds = ("as accurate", "as accurate, no coarser than any choice", "within what was asked")
    lines = ["| scene, observable | asked [%] | delivered [%] | " + " | ".join(f"{kind}: work, seconds" for kind in kinds) +
             " | spacing, sound speed, Courant number or step | of the cheapest as accurate |",
             "|---|---:|---:|---:|---:|---:|---|---|"]
    ratios, rows = {}, []
    for name, (_, of, _) in scenes.items():
        for value, row in asked[name]:
            choice = ("choice", value)
            if choice not in errors[name]:
                why = {0: "finer than the grid", "too long": "too long"}.get(row["exit"], "refused")
                lines.append(f"| {name}, `{of}` | {100 * value:g} | {why} | | | | | |")
                continue
            delivered = errors[name][choice]
            coarsest = 1.01 * max(settings_of[name, key]["spacing"] for key in errors[name] if key[0] == "choice")
            compared = over(name, choice, delivered), over(name, choice, delivered, coarsest), over(name, choice, value)
            for kind, ratio in zip(kinds, compared):
                for what, number in zip(("work", "seconds"), ratio or ()):
                    ratios.setdefault((kind, what), []).append(number)
            texts = [f"{ratio[0]:.2f}, {ratio[1]:.2f}" if ratio else "none" for ratio in compared]
            best = words_of(settings_of[name, compared[0][2]]) if compared[0] else ""
            lines.append(f"| {name}, `{of}` | {100 * value:g} | {100 * delivered:.2g} | {' | '.join(texts)} | "
                         f"{words_of(settings_of[name, choice])} | {best} |")
            rows.append({"scene": name, "observable": of, "asked": value, "expected": row["expected"], "delivered": delivered,
                         **{f"{kind}: {what}": ratio[k] if ratio else "" for kind, ratio in zip(kinds, compared)
                            for k, what in enumerate(("work", "seconds"))}})
    for (kind, what), numbers in ratios.items():
        numbers.sort()
        lines.append(f"{what} over the cheapest point {kind}: {len(numbers)} of {sum(map(len, asked.values()))}, median "
                     f"{(numbers[(len(numbers) - 1) // 2] + numbers[len(numbers) // 2]) / 2:.2f}, worst {numbers[-1]:.2f}, "
                     f"{sum(number <= 1.3 for number in numbers)} up to 1.3")
    with open(out / "choices.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    (out / "grid.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0


def words_of(settings):
    """A point's settings, short."""
    if "sound_speed" not in settings:
        return f"{settings['spacing']:.3g} m, {1000 * settings['dt']:.3g} ms"
    return f"{settings['spacing']:.3g} m, {settings['sound_speed']:.3g} m/s, {settings['courant']:.2g}"


def presets(options, out):
    """CPU seconds or, on a GPU, seconds of a run at each --quality, and the largest error over the run of two starts [%]."""
    scenes = {"slab": (slab(), []), "stefan": (stefan(), []), "column": (column(), []),
              "dam_break": ("dam_break", ["--scale", 0.6, "--time", 1]),
              "ice_block": ("ice_block", ["--scale", 0.8, "--time", 4]),
              "floating": ("floating", ["--scale", 0.8, "--time", 2])}

    def measure(job):
        name, quality = job
        text, more = scenes[name]
        scene = text
        if text != name:
            scene = out / f"{name}_{quality}.yaml"
            scene.write_text(text)
        elif quality == "truth":
            more = [*more[:1], 2 * more[1], *more[2:]]
        words = ["--scale", 2] if quality == "truth" and text != name else []
        words += [] if quality == "truth" else ["--quality", quality]
        where = out / f"{name}_{quality}"
        done = run([options.meltsim, "trade", scene, *more, *words, "--ensemble", 2, *machine(options), "--out", where])
        if done.returncode != 0:
            sys.exit(f"{name}, {quality}: {done.stderr.strip()}")
        return json.loads((where / "ensemble.json").read_text())

    jobs = [(name, quality) for quality in ("truth", *QUALITIES) for name in reversed(scenes)]
    results = dict(zip(jobs, side_by_side(options, measure, jobs)))
    lines = ["| scene | observable | `draft` | `balanced` | `accurate` |", "|---|---|---|---|---|"]
    for name in scenes:
        truths = results[name, "truth"]["observables"]
        for k, (of, truth) in enumerate(truths.items()):
            cells = []
            for quality in QUALITIES:
                result = results[name, quality]
                place = list(result["observables"]).index(of)
                exact = result["observables"][of].get("exact")
                scale = result["observables"][of]["scale"] or max(abs(value) for value in truth["mean"])
                errors = [100 * largest(run["values"][place], exact or truth["mean"]) / scale for run in result["runs"]]
                seconds = min(run["wall_s"] for run in result["runs"])
                cells.append((f"{seconds:.2g} s, " if k == 0 else "") + " and ".join(f"{e:.2g}" for e in errors))
            lines.append(f"| {name if k == 0 else ''} | `{of}`{' (exact)' if exact else ''} | " + " | ".join(cells) + " |")
    (out / "presets.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0


def budgets(options, out):
    """Frames that took longer than 1.05 times their budget, under --budget at several shares of what a frame takes. A GPU takes a few
    tenths of a millisecond for any frame that is waited for: give it --scale 4."""
    scale = 0.8 * options.scale
    scenes = {"dam_break": ["--scale", scale, "--fps", 200, "--time", 2], "ice_block": ["--scale", scale, "--fps", 150, "--time", 2],
              "floating": ["--scale", scale, "--fps", 200, "--time", 1.5]}
    lines = ["| run | a frame takes [ms] | budget [ms] | late | most in a row | longest [ms] | simulated | to the bit again |",
             "|---|---:|---:|---:|---:|---:|---:|---|"]
    for name, more in scenes.items():
        quiet = ["--export", "none", "--no-page", "--no-still", *machine(options)]
        done = run([options.meltsim, "run", name, *more, *quiet, "--out", out / name])
        if done.returncode != 0:
            sys.exit(f"{name}: {done.stderr.strip()}")
        free = json.loads((out / name / "run.json").read_text())
        frame = 1e3 * free["timings"]["wall"]["stepping_s"] / max(1, free["final"]["frames"])
        for share in (2, 1, 0.5, 0.1):
            where, budget = out / f"{name}_{share}", float(f"{share * frame:.2g}")
            done = run([options.meltsim, "run", name, *more, *quiet, "--budget", f"{budget}ms", "--out", where])
            if done.returncode != 0:
                sys.exit(f"{name}, {budget} ms: {done.stderr.strip()}")
            result = json.loads((where / "run.json").read_text())
            late = [ms > 1.05 * budget for ms in result["budget"]["frame_ms"]]
            row = longest_row = 0
            for missed in late:
                row = row + 1 if missed else 0
                longest_row = max(longest_row, row)
            again = out / f"{name}_{share}_again"
            repeated = run([options.meltsim, "run", name, *more, *quiet, "--repeat", where, "--out", again])
            same = repeated.returncode == 0 and all(
                result["final"][key] == json.loads((again / "run.json").read_text())["final"][key]
                for key in ("kinetic_J", "thermal_J", "com_solid_y", "momentum_x"))
            simulated = result["final"]["time_s"]
            asked = simulated + result["budget"]["not_simulated_s"]
            lines.append(f"| `{name} {' '.join(str(word) for word in more)}` | {frame:.2g} | {budget:g} | {sum(late)} of {len(late)} | "
                         f"{longest_row} | {max(result['budget']['frame_ms']):.2g} | "
                         f"{simulated:.3g} of {asked:.3g} s | {'yes' if same else 'NO'} |")
            print(lines[-1], flush=True)
    (out / "budgets.md").write_text("\n".join(lines) + "\n")
    return 0


def report(rows, out, file):
    with open(out / f"{file}.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    ran = [r for r in rows if r["exit"] == 0]
    kept = sum(r["delivered"] <= r["asked"] for r in ran)
    # At the coarsest settings that there are nothing is cheaper, however good they are.
    bought = [r for r in ran if r["expected"] > 0.99 * r["asked"] / 1.5]
    not_dear = sum(r["delivered"] >= r["asked"] / 4 for r in bought)
    near = sum(0.5 <= r["delivered"] / r["expected"] <= 2 for r in ran if r["expected"] > 0)
    honest = sum(0.5 <= r["estimated"] / r["delivered"] <= 2 for r in ran if r["delivered"] > 0)
    refused = sum(r["exit"] in (1, 2) for r in rows)
    probing = sorted(r["probing_s"] for r in ran if r["probing_s"])
    if probing:
        print(f"probing: {probing[len(probing) // 2]:.2g} s (median), {probing[-1]:.2g} s at most, {max(r['probes'] for r in ran)} probes")
    print(f"{len(rows)} asked, {refused} refused, {len(ran)} run: {kept} within what was asked; {len(bought)} not at the coarsest "
          f"settings, {not_dear} of them at a quarter of it or more; {near} of {len(ran)} within a factor 2 of what was expected, "
          f"{honest} of what was estimated after the run")
    draw(ran, out / f"{file}.svg")
    return 0


def draw(rows, path):
    """Delivered against asked, logarithmic."""
    size, margin, low, high = 420, 60, -4.0, 0.0

    def place(value):
        return margin + (max(low, min(high, math.log10(max(value, 1e-9)))) - low) / (high - low) * (size - 2 * margin)

    marks = {"pressure": "#2f62c4", "temperature": "#d1392b", "melted": "#2e9e4f", "front": "#8a4fc9", "level": "#c98a2f"}
    kinds = [row["of"].split("@")[0] for row in rows]
    marks = {kind: colour for kind, colour in marks.items() if kind in kinds}
    text = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" font-family="Helvetica" font-size="12">',
            f'<rect width="{size}" height="{size}" fill="#fff"/>']
    for decade in range(-4, 1):
        at = place(10.0 ** decade)
        text.append(f'<path d="M{at:.0f} {margin}V{size - margin}M{margin} {size - at:.0f}H{size - margin}" stroke="#ddd"/>'
                    f'<text x="{at:.0f}" y="{size - margin + 18}" text-anchor="middle">{100 * 10.0 ** decade:g} %</text>'
                    f'<text x="{margin - 6}" y="{size - at + 4:.0f}" text-anchor="end">{100 * 10.0 ** decade:g} %</text>')
    text.append(f'<path d="M{margin} {size - margin}L{size - margin} {margin}" stroke="#333"/>')
    for row in rows:
        text.append(f'<circle cx="{place(row["asked"]):.1f}" cy="{size - place(row["delivered"]):.1f}" r="4" '
                    f'fill="{marks.get(row["of"].split("@")[0], "#555")}" fill-opacity="0.7"/>')
    for k, (name, colour) in enumerate(marks.items()):
        text.append(f'<text x="{margin + 8}" y="{margin + 16 * (k + 1)}" fill="{colour}">{name}</text>')
    text.append(f'<text x="{size / 2}" y="{size - 14}" text-anchor="middle">error asked for</text>'
                f'<text transform="translate(14 {size / 2}) rotate(-90)" text-anchor="middle">error delivered</text></svg>')
    path.write_text("\n".join(text) + "\n")


def reference(_, out):
    """Error of the front of a dam break against CPU seconds, logarithmic: meltsim and DFSPH."""
    record = sorted((Path(__file__).parent / "records").glob("dfsph-*.csv"))[-1]
    with open(record, newline="") as file:
        rows = [r for r in csv.DictReader(line for line in file if not line.startswith("#")) if r["scene"] == "dam_break"]
    size, margin, seconds, errors = 420, 60, (0.1, 100.0), (0.1, 10.0)

    def place(value, span):
        return margin + math.log(value / span[0]) / math.log(span[1] / span[0]) * (size - 2 * margin)

    text = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" font-family="Helvetica" font-size="12">',
            f'<rect width="{size}" height="{size}" fill="#fff"/>']
    for tick in (0.1, 1.0, 10.0, 100.0):
        at = place(tick, seconds)
        text.append(f'<path d="M{at:.0f} {margin}V{size - margin}" stroke="#ddd"/>'
                    f'<text x="{at:.0f}" y="{size - margin + 18}" text-anchor="middle">{tick:g} s</text>')
    for tick in (0.1, 0.3, 1.0, 3.0, 10.0):
        at = size - place(tick, errors)
        text.append(f'<path d="M{margin} {at:.0f}H{size - margin}" stroke="#ddd"/>'
                    f'<text x="{margin - 6}" y="{at + 4:.0f}" text-anchor="end">{tick:g} %</text>')
    for k, (code, colour) in enumerate((("meltsim", "#2f62c4"), ("DFSPH", "#d1392b"))):
        points = sorted((float(r["cpu_s"]), float(r["front"])) for r in rows if r["code"] == code)
        text += [f'<circle cx="{place(s, seconds):.1f}" cy="{size - place(e, errors):.1f}" r="4" fill="{colour}"/>' for s, e in points]
        text.append(f'<text x="{size - margin - 70}" y="{margin + 16 * (k + 1)}" fill="{colour}">{code}</text>')
    text.append(f'<text x="{size / 2}" y="{size - 14}" text-anchor="middle">CPU time of one thread</text>'
                f'<text transform="translate(14 {size / 2}) rotate(-90)" text-anchor="middle">error of the front</text></svg>')
    (out / "reference.svg").write_text("\n".join(text) + "\n")
    return 0


WAYS = {"fronts": fronts, "calibrate": calibrate, "flows": calibrate_flows, "grid": grid, "presets": presets, "budgets": budgets,
        "reference": reference}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meltsim")
    parser.add_argument("what", choices=list(WAYS))
    parser.add_argument("out")
    parser.add_argument("--backend", default="auto")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--time-limit", type=float, default=20)
    parser.add_argument("--total", type=float, default=240)
    parser.add_argument("--longest", type=float, default=1800, help="seconds that a run may take")
    parser.add_argument("--jobs", type=int, default=1, help="scenes at once")
    parser.add_argument("--finer", type=lambda text: [float(x) for x in text.split(",")], default=[1.4, 2, 3],
                        help="flows: three resolutions that the truth is taken from, e.g. 2,4,6 on a GPU")
    parser.add_argument("--only", help="flows, grid: scenes, with commas")
    options = parser.parse_args()
    options.meltsim = str(Path(options.meltsim).resolve())
    out = Path(options.out)
    if out.exists() and any(out.iterdir()) and options.what != "flows":
        print(f"{out}: is not empty; name a new directory", file=sys.stderr)
        return 5
    out.mkdir(parents=True, exist_ok=True)
    return WAYS[options.what](options, out)


if __name__ == "__main__":
    sys.exit(main())
