# SPDX-License-Identifier: Apache-2.0
"""Reads what `ncu --csv` prints, in both of its layouts. Standard library only.

--page raw has a row per launch, a column per metric and a row of units below the header; --page details has a row per
launch and metric. Lines of ncu itself (==PROF==) and of the program stand around the table.
"""
import csv
import io
import re

# What stage_table.py looks at; gpu_suite.sh asks ncu for these names.
TIME = "gpu__time_duration.sum"
DRAM_BYTES = "dram__bytes.sum"
DRAM = "dram__throughput.avg.pct_of_peak_sustained_elapsed"
L2_BYTES = "lts__t_bytes.sum"
L2 = "lts__throughput.avg.pct_of_peak_sustained_elapsed"
L1 = "l1tex__throughput.avg.pct_of_peak_sustained_active"
ISSUE = "sm__inst_issued.avg.pct_of_peak_sustained_elapsed"
REGISTERS = "launch__registers_per_thread"
OCCUPANCY = "sm__warps_active.avg.pct_of_peak_sustained_active"
METRICS = [TIME, DRAM_BYTES, DRAM, L2_BYTES, L2, L1, ISSUE, REGISTERS, OCCUPANCY]

# What ncu's own sections have in their place.
SECTION_BYTES = ("dram__bytes_read.sum", "dram__bytes_write.sum")
SECTION_ISSUE = "sm__inst_issued.avg.pct_of_peak_sustained_active"

# To bytes and nanoseconds; everything else stays as it is.
UNITS = {"Kbyte": 1e3, "Mbyte": 1e6, "Gbyte": 1e9, "Tbyte": 1e12, "us": 1e3, "usecond": 1e3, "ms": 1e6, "msecond": 1e6,
         "s": 1e9, "second": 1e9}


def number(text, unit):
    """None for what ncu could not measure: n/a, (!) n/a, nan, nothing."""
    try:
        value = float(text.replace(",", ""))
    except (ValueError, AttributeError):
        return None
    return value * UNITS.get(unit, 1.0) if value == value else None


def launches(text):
    """[(kernel name, {metric: value})] in order of launch; empty when there is no table."""
    found = table_of(text)
    for _, metrics in found:
        if DRAM_BYTES not in metrics and all(m in metrics for m in SECTION_BYTES):
            metrics[DRAM_BYTES] = sum(metrics[m] for m in SECTION_BYTES)
        if ISSUE not in metrics and SECTION_ISSUE in metrics:
            metrics[ISSUE] = metrics[SECTION_ISSUE]
    return found


def table_of(text):
    lines = text.splitlines()
    start = next((i for i, line in enumerate(lines) if line.startswith('"ID",')), None)
    if start is None:
        return []
    table = [line for line in lines[start:] if line.startswith('"')]
    rows = list(csv.DictReader(io.StringIO("\n".join(table))))
    found = {}  # by id, in order
    if rows and "Metric Name" in rows[0]:
        for row in rows:
            _, metrics = found.setdefault(row["ID"], (row["Kernel Name"], {}))
            value = number(row["Metric Value"], row["Metric Unit"])
            if value is not None:
                metrics[row["Metric Name"]] = value
        return list(found.values())
    units = {}
    for row in rows:
        if not row["ID"]:
            units = row
            continue
        metrics = {name: number(value, units.get(name, "")) for name, value in row.items() if name and "__" in name}
        found[row["ID"]] = (row["Kernel Name"], {k: v for k, v in metrics.items() if v is not None})
    return list(found.values())


def refusal(text):
    """Why there is no table: what ncu said last, or nothing."""
    if "ERR_NVGPUCTRPERM" in text:
        return "the driver lets no ordinary user read performance counters (ERR_NVGPUCTRPERM)"
    said = re.findall(r"^==ERROR== *(.+)$", text, re.MULTILINE)
    return said[-1].strip() if said else ""
