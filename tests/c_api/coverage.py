# SPDX-License-Identifier: Apache-2.0
"""coverage.py ROOT: what hosts in C and Python can reach of the descriptions and calls of C++. Every member of a description, every
call of World and every shape, has to be in include/meltsim/meltsim.h and in the Python package, under its own name or the one that is said here, or be listed
here with the reason why not. Every function of C has to be called by its fuzzer. Exit code 1 where something is missing, or is listed and there after all."""
import re
import sys
from pathlib import Path

root = Path(sys.argv[1])


def read(path):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", (root / path).read_text(encoding="utf-8"), flags=re.S)


def members(path, struct):
    body = re.search(r"struct (?:MELTSIM_API )?%s \{(.*?)\n\};" % struct, read(path), flags=re.S).group(1)
    found = []
    for statement in body.split(";"):
        if "(" in re.sub(r"\{.*", "", statement, flags=re.S) or "using " in statement or "static" in statement:
            continue
        declared = re.sub(r"=.*|\{.*", "", statement, flags=re.S).strip()
        declared = re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", declared))
        names = re.findall(r"(\w+)\s*(?:,|$)", declared)
        found += names if " " in declared else []
    return found


# What a member is called there; "-": not there, for the reason behind it.
C = {
    "WorldDesc": {"header_version": "version", "precision": "double_precision", "domain": "domain_min", "heat": "heat_model",
                  "solute": "solute_time_scale"},
    "DomainDesc": {"min": "domain_min", "max": "domain_max", "friction": "wall_friction", "contact_angle": "wall_contact_angle",
                   "velocity": "wall_velocity", "heat": "wall_heat"},
    "HeatDesc": {"model": "heat_model", "time_scale": "heat_time_scale", "interval": "heat_interval", "max_stages": "heat_max_stages",
                 "max_supersteps": "heat_max_supersteps", "level_tolerance": "heat_level_tolerance"},
    "SoluteDesc": {"time_scale": "solute_time_scale", "max_supersteps": "solute_max_supersteps"},
    "FluidDesc": {"fractions": "meltsim_world_add_mixture"},
    "SolidDesc": {"fixed": "- motion says it"},
    "SurfaceHeatDesc": {"temperature_points": "- set from step to step: meltsim_world_set_wall_heat, set_body_heat",
                        "flux_points": "- likewise"},
    "EmitterDesc": {"fractions": "meltsim_world_add_mixture_emitter"},
    "MaterialDesc": {name: "meltsim_world_add_species" for name in (
        "dissolves_in", "solubility", "solubility_points", "diffusivity_in", "heat_of_solution", "transfer_coefficient")},
}
PYTHON = {
    "WorldDesc": {"header_version": "- that of the package", "domain": "size", "heat": "heat", "solute": "solute"},
}
STRUCTS = [("include/meltsim/desc.hpp", s, c) for s, c in (
    ("WorldDesc", "meltsim_world_desc"), ("DomainDesc", "meltsim_world_desc"), ("HeatDesc", "meltsim_world_desc"),
    ("SoluteDesc", "meltsim_world_desc"), ("SurfaceHeatDesc", "meltsim_surface_heat"), ("FluidDesc", "meltsim_fluid_desc"),
    ("SolidDesc", "meltsim_solid_desc"), ("EmitterDesc", "meltsim_emitter_desc"), ("HeatRegionDesc", "meltsim_heat_region_desc"),
    ("ForceFieldDesc", "meltsim_force_field_desc"))] + [("include/meltsim/material.hpp", "MaterialDesc", "meltsim_material_desc")]
# Calls that C has under another name, or leaves to its readings.
CALLS = {
    "add_solid": "add_solid", "ledger": "- totals() has the sums", "pieces": "- a reading has them", "lattice": "- for tests",
    "overlap": "bodies_in", "take_samples": "- a reading has them", "plan": "interval", "scheduler": "- its calls are below",
    "resolved": "- for people", "desc": "- the host has it", "material": "- the host has it", "force_field": "- the host has it",
    "watched_bodies": "- take_forces() counts them",
    "precision": "- the host has it",
}

PYTHON_CALLS = {
    "lattice": "- for tests", "device_state": "state", "check_view": "- arrays and views say so themselves", "scheduler": "- its calls are below",
    "desc": "- the host has it", "material": "- the host has it", "force_field": "- the host has it", "watched_bodies": "- take_forces() has them",
}

# Calls of its Scheduler, which C and Python have beside those of World.
SCHEDULER = {"insert_after": "add_stage", "remove": "remove_stage"}
SCHEDULER_CALLS = {**SCHEDULER, "enable_timings": "- for people"}

header = (root / "include/meltsim/meltsim.h").read_text(encoding="utf-8")
python = (root / "python/src/world.cpp").read_text(encoding="utf-8") + "".join(
    p.read_text(encoding="utf-8") for p in sorted((root / "python/meltsim").glob("*.py")))
python_world = python[python.index("nb::class_<HostWorld>(m"):]
wrong = []


def look(what, name, aliases, there):
    said = aliases.get(name, name)
    absent = said.startswith("-")
    if there(name if absent else said) == absent:
        wrong.append(f"{what}: {name}: " + ("listed as absent, and there" if absent else f"is not there as {said}"))


for path, struct, c_struct in STRUCTS:
    body = re.search(r"typedef struct %s \{(.*?)\} %s;" % (c_struct, c_struct), header, flags=re.S).group(1)
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.S)
    for name in members(path, struct):
        look(f"C: {struct}", name, C.get(struct, {}),
             lambda n: n in header if n.startswith("meltsim_") else re.search(r"\b(has_)?%s\b" % n, body) is not None)
        look(f"Python: {struct}", name, PYTHON.get(struct, {}), lambda n: f'"{n}"' in python or re.search(r"\b%s\b" % n, python) is not None)

world = re.search(r"class MELTSIM_API World \{(.*?)\n private:", read("include/meltsim/world.hpp"), flags=re.S).group(1)
calls = sorted(set(re.findall(r"[\w>&*] (\w+)\([^;{]*\)[^;{]*;", world)) - {"operator", "World", "create"})
for name in calls:
    look("C: World", name, CALLS, lambda n: f"meltsim_world_{n}(" in header)
    look("Python: World", name, PYTHON_CALLS, lambda n: re.search(r'\.def(?:_prop_ro)?\(\s*"%s"' % n, python_world) is not None)
scheduler = re.search(r"class MELTSIM_API Scheduler \{(.*?)\n\};", read("include/meltsim/scheduler.hpp"), flags=re.S).group(1)
for name in re.findall(r"virtual Status (\w+)\(", scheduler):
    look("C: Scheduler", name, SCHEDULER_CALLS, lambda n: f"meltsim_world_{n}(" in header)
    look("Python: Scheduler", name, SCHEDULER, lambda n: re.search(r'\.def\(\s*"%s"' % n, python_world) is not None)
shapes = re.findall(r"static Shape (\w+)\(|Shape (transformed)\(", read("include/meltsim/shape.hpp"))
shape_calls = (root / "python/src/shape.cpp").read_text(encoding="utf-8")
for name in ("".join(s) for s in shapes):
    look("C: Shape", name, {"transformed": "transform"}, lambda n: f"meltsim_shape_{n}(" in header)
    look("Python: Shape", name, {"subtract": "__sub__"}, lambda n: f'"{n}"' in shape_calls)
fuzzer = (root / "tests/fuzz/c_fuzz.cpp").read_text(encoding="utf-8")
for name in sorted(set(re.findall(r"\b(meltsim_\w+)\(", header))):
    if not re.search(r"_init(_sized)?$", name) and name not in fuzzer:
        wrong.append(f"C: {name}() is not called by tests/fuzz/c_fuzz.cpp")
print("\n".join(wrong))
sys.exit(1 if wrong else 0)
