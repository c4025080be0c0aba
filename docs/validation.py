#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Turns records of `meltsim validate --out DIR` into docs/validation.md and the figures beside it.

  docs/validation.py [--out docs] [--update] [LABEL=]DIR_OR_JSON ...

One error column per label, in the order given (default label: device and precision); records of one label are parts
of one run, joined by case. Figures show the first record that has them. --update puts cells into the page that is there,
by label, and leaves all else as it is. Needs matplotlib. A developer runs this by hand; no build does.
"""
import argparse
import json
import math
import re
import sys
from pathlib import Path

COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b", "#17becf", "#7f7f7f")
MARKERS = "osD^v<>p"


def number(value, digits=3):
    if value is None or isinstance(value, float) and math.isnan(value):
        return "nan"
    return f"{value:.{digits}g}"


def with_unit(value, unit):
    return number(value) if unit in ("", "-") else f"{number(value)} {unit}"


def escaped(text):
    """A cell of a Markdown table is one line without bars."""
    return " ".join(str(text).split()).replace("|", "\\|")


class Record:
    """One validation.json."""

    def __init__(self, argument):
        label, _, path = argument.rpartition("=")
        path = Path(path)
        if path.is_dir():
            path /= "validation.json"
        self.path = path
        self.json = json.loads(path.read_text())
        if self.json.get("format") != 1:
            raise ValueError(f"{path}: format {self.json.get('format')!r}, expected 1")
        self.cases = {case["name"]: case for case in self.json["cases"]}
        backend = self.json["backend"]
        self.label = label or f"{backend['name']}, {self.json['precision']}"

    def hardware(self):
        backend, machine = self.json["backend"], self.json["machine"]
        threads = self.json["threads"] or machine["cpus"]
        if backend["name"] == "cpu":
            return f"{machine['cpu'] or 'a CPU'}, {threads} thread{'s' if threads != 1 else ''}"
        return f"{backend['device']} ({machine['cpu'] or 'a CPU'})"


def joined(records):
    """Cases in the order of the records: the first that has one decides."""
    names = []
    for record in records:
        names += [name for name in record.cases if name not in names]
    return names


def row_keys(records, name):
    keys = []
    for record in records:
        keys += [row["quantity"] for row in record.cases.get(name, {"rows": []})["rows"] if row["quantity"] not in keys]
    return keys


def case_section(records, name, figures):
    first = next(record.cases[name] for record in records if name in record.cases)
    lines = [f"### `{name}`", "", f"{first['what'][:1].upper()}{first['what'][1:]}. Reference: {first['source']}.", ""]
    labels = [record.label for record in records]
    lines.append("| quantity | reference | target | " + " | ".join(escaped(label) for label in labels) + " |")
    lines.append("|---|---|---|" + "---|" * len(labels))
    for key in row_keys(records, name):
        rows = [next((row for row in record.cases.get(name, {"rows": []})["rows"] if row["quantity"] == key), None)
                for record in records]
        known = next(row for row in rows if row)
        cells = ["" if row is None else cell(row) for row in rows]
        target = with_unit(known["target"], known["unit"])
        lines.append(f"| {escaped(key)} | {number(known['reference'], 6)} | {target} | " + " | ".join(cells) + " |")
    lines.append("| seconds | | | " + " | ".join(
        number(record.cases[name]["seconds"]) if name in record.cases else "" for record in records) + " |")
    lines.append("")
    for record in records:
        case = record.cases.get(name)
        if case and case["error"]:
            lines += [f"**{escaped(record.label)} could not run it:** {escaped(case['error'])}", ""]
    reasons = []
    for row in first["rows"]:
        if row["reason"] and row["reason"] not in reasons:
            reasons.append(row["reason"])
    if reasons:
        lines += ["Targets: " + "; ".join(escaped(reason) for reason in reasons) + ".", ""]
    notes = []
    for record in records:
        note = record.cases.get(name, {}).get("note", "")
        if note and note not in notes:
            notes.append(note)
            lines += [escaped(note), ""]
    for file, title in figures.get(name, []):
        lines += [f"![{escaped(title)}]({file})", ""]
    return lines


def draw(plot, path, label):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(9, 5.4), dpi=100)
    # A curve and its reference of the same name (up to "ours"/"reference") would differ in colour otherwise.
    ours = [curve for curve in plot["curves"] if not curve["reference"]]
    theirs = [curve for curve in plot["curves"] if curve["reference"]]
    paired = len(ours) == len(theirs) and len(ours) > 1
    for i, curve in enumerate(ours):
        axes.plot(curve["x"], curve["y"], color=COLOURS[i % len(COLOURS)], linewidth=1.8, label=curve["name"],
                  marker="." if len(curve["x"]) <= 40 else None, zorder=3)
    for i, curve in enumerate(theirs):
        colour = COLOURS[i % len(COLOURS)] if paired else ("#222222", "#777777", "#bb7700", "#006677")[i % 4]
        few = len(curve["x"]) <= 60
        axes.plot(curve["x"], curve["y"], color=colour, label=curve["name"], zorder=4,
                  **({"linestyle": "none", "marker": MARKERS[i % len(MARKERS)], "markersize": 6,
                      "markerfacecolor": "none"} if few else {"linestyle": "--", "linewidth": 1.5}))
    axes.set_title(plot["title"], fontsize=13)
    axes.set_xlabel(plot["x_label"], fontsize=11)
    axes.set_ylabel(plot["y_label"], fontsize=11)
    axes.grid(True, color="#dddddd", linewidth=0.7)
    axes.legend(fontsize=9, framealpha=0.9)
    axes.text(0.995, -0.13, label, transform=axes.transAxes, ha="right", fontsize=8, color="#666666")
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": None})  # no version: the same data give the same bytes
    plt.close(figure)


def draw_figures(records, out):
    """Case -> [(file relative to the document, title)]; figures of the first record that has the plot."""
    figures, done = {}, set()
    for record in records:
        for name, case in record.cases.items():
            for plot in case["plots"]:
                if plot["name"] in done or not any(curve["x"] for curve in plot["curves"]):
                    continue
                done.add(plot["name"])
                (out / "validation").mkdir(parents=True, exist_ok=True)
                draw(plot, out / "validation" / f"{plot['name']}.png", record.label)
                figures.setdefault(name, []).append((f"validation/{plot['name']}.png", plot["title"]))
    return figures


def document(records, figures):
    lines = ["# Validation", "",
             "What meltsim computes, against exact solutions, published numbers and experiments. Made by",
             "`docs/validation.py` from records of `meltsim validate --long --out DIR`; do not edit by hand.", "",
             "| run | hardware | precision | meltsim | commit | date | cases passed | minutes |",
             "|---|---|---|---|---|---|---|---|"]
    for record in records:
        j = record.json
        passed = sum(case["pass"] for case in record.cases.values())
        unfinished = "" if j["finished"] else " (stopped early)"
        lines.append(f"| {escaped(record.label)} | {escaped(record.hardware())} | {j['precision']} | {j['version']} | "
                     f"{escaped(j['commit'] or 'not given')} | {j['date'][:10]} | {passed} of {len(record.cases)}"
                     f"{unfinished} | {number(j['summary']['seconds'] / 60)} |")
    lines += ["", "Each cell is the error of that run and whether it meets the target.", "", "## Overview", "",
              "| case | reference | " + " | ".join(escaped(record.label) for record in records) + " |",
              "|---|---|" + "---|" * len(records)]
    names = joined(records)
    for name in names:
        case = next(record.cases[name] for record in records if name in record.cases)
        marks = []
        for record in records:
            mine = record.cases.get(name)
            if mine is None:
                marks.append("")
            else:
                good = sum(row["pass"] for row in mine["rows"])
                marks.append(f"{'✓' if mine['pass'] else '**✗**'} {good}/{len(mine['rows'])}")
        lines.append(f"| [`{name}`](#{name.replace('.', '')}) | {escaped(case['source'])} | " + " | ".join(marks) + " |")
    lines.append("")
    subject = None
    for name in names:
        if name.split(".")[0] != subject:
            subject = name.split(".")[0]
            lines += [f"## {subject.capitalize()}", ""]
        lines += case_section(records, name, figures)
    return "\n".join(lines).rstrip() + "\n"


def cell(row):
    return f"{with_unit(row['error'], row['unit'])} {'✓' if row['pass'] else '**✗**'}"


def updated(page, records):
    """The page with the cells of these records put in; whatever they do not hold stays as it is."""
    lines, case, columns = [], None, []
    for line in page.splitlines():
        heading = re.match(r"### `(.+)`", line)
        if heading:
            case = heading[1]
        cells = re.split(r"(?<!\\)\|", line)[1:-1] if line.startswith("|") else []
        if cells and cells[0].strip() in ("quantity", "case"):
            columns = [c.strip() for c in cells]
        for record in records:
            if not cells or record.label not in columns:
                continue
            at = columns.index(record.label)
            name = re.match(r" \[`(.+?)`\]", cells[0]) if columns[0] == "case" else None
            mine = record.cases.get(name[1] if name else case if columns[0] == "quantity" else None)
            if mine is None:
                continue
            good = sum(row["pass"] for row in mine["rows"])
            row = next((r for r in mine["rows"] if escaped(r["quantity"]) == cells[0].strip()), None)
            if name:
                cells[at] = f" {'✓' if mine['pass'] else '**✗**'} {good}/{len(mine['rows'])} "
            elif row:
                cells[at] = f" {cell(row)} "
            elif cells[0].strip() == "seconds":
                cells[at] = f" {number(mine['seconds'])} "
        lines.append("|" + "|".join(cells) + "|" if cells else line)
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="directory of validation.md")
    parser.add_argument("--update", action="store_true",
                        help="only put the cells of these records into validation.md, by label")
    parser.add_argument("records", nargs="+", metavar="[LABEL=]DIR_OR_JSON")
    arguments = parser.parse_args()
    try:
        records = []
        for record in map(Record, arguments.records):
            whole = next((r for r in records if r.label == record.label), None)
            if whole is None:
                records.append(record)
            else:
                whole.cases.update(record.cases)
    except (OSError, ValueError, KeyError) as error:
        print(f"validation.py: {error}", file=sys.stderr)
        return 1
    if arguments.update:
        page = arguments.out / "validation.md"
        page.write_text(updated(page.read_text(), records))
        return 0
    figures = draw_figures(records, arguments.out)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "validation.md").write_text(document(records, figures))
    print(f"wrote {arguments.out / 'validation.md'}, {sum(map(len, figures.values()))} figures")
    return 0


if __name__ == "__main__":
    sys.exit(main())
