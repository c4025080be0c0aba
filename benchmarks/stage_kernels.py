# SPDX-License-Identifier: Apache-2.0
"""Which kernel belongs to which stage, read from the sources: src/pipeline/pipeline.def has the stages in order,
src/<module>/stages.hpp the bodies and verbs of each. Standard library only.

A launch's name carries its body (`each<meltsim::v0::sph::ForcesBody<float>>`), and most bodies belong to one stage. What
is left - fills, the second half of a reduction, CUB's sort, bodies of two stages - goes by its place between those.
"""
import re

# What a kernel's name says of the verb that launched it (cuda/exec). A bucket's counts are summed by a scan, too.
VERBS = [("sort", r"RadixSort|Onesweep|radix_sort"), ("bucket", r"CountBody|PlaceBody"),
         ("scan", r"DeviceScan|DeviceCompactInit"), ("bucket", r"DeviceScan"),
         ("reduce", r"kernels::reduce<|DeviceReduce"), ("fill", r"FillBody"), ("copy", r"CopyBody")]


def stage_order(root):
    """["step.begin", "spatial.keys", ...]"""
    text = (root / "src/pipeline/pipeline.def").read_text(encoding="utf-8")
    return [f"{module}.{stage}" for module, stage in re.findall(r"^MELTSIM_STAGE\((\w+), (\w+),", text, re.MULTILINE)]


def functions_of(text):
    """name -> text between its braces, of every `void name(E& ex, ...)` and `void name(const core::Frame<T>& w, ...)`."""
    found = {}
    for match in re.finditer(r"void (\w+)\((?:E& ex|const core::Frame)[^)]*\)\s*\{", text):
        depth, end = 1, match.end()
        while depth and end < len(text):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        found[match.group(1)] = text[match.end():end - 1]
    return found


def with_called(name, functions, seen=()):
    """A function's text and that of what it calls."""
    text = functions[name]
    for other in functions:
        if other not in (name, *seen) and re.search(rf"\b{other}(<[^;]*?>)?\((?:ex|w)\b", text):
            text += with_called(other, functions, (name, *seen))
    return text


class Kernels:
    def __init__(self, root):
        self.order = stage_order(root)
        self.bodies = {}  # "module::Body" -> stages
        self.verbs = {}  # verb -> stages
        modules = {stage.split(".")[0] for stage in self.order}
        for module in sorted(modules):
            functions = functions_of((root / "src" / module / "stages.hpp").read_text(encoding="utf-8"))
            for name in functions:
                stage = f"{module}.{name}"
                if stage not in self.order:
                    continue
                text = with_called(name, functions)
                for space, body in re.findall(r"\b(?:(core)::)?(\w+Body)\b", text):
                    self.bodies.setdefault(f"{space or module}::{body}", set()).add(stage)
                for verb in re.findall(r"\bex\.(\w+)\(", text):
                    self.verbs.setdefault(verb, set()).add(stage)
        self.modules = modules

    def candidates(self, kernel):
        for module, body in re.findall(r"\b(\w+)::(\w+Body)\b", kernel):
            if module in self.modules or f"{module}::{body}" in self.bodies:
                return self.bodies.get(f"{module}::{body}") or {s for s in self.order if s.startswith(module + ".")}
        verbs = [verb for verb, pattern in VERBS if re.search(pattern, kernel)]
        if verbs:
            return set().union(*(self.verbs.get(verb, set()) for verb in verbs))
        return set(self.order)

    def stages_of(self, kernels):
        """The stage of every launch, in order of launch; None where it cannot be told."""
        sets = [self.candidates(k) for k in kernels]
        # A stage that has bodies of its own, none of which was launched, did not run.
        launched = {f"{m}::{b}" for k in kernels for m, b in re.findall(r"\b(\w+)::(\w+Body)\b", k)}
        own = {}
        for body, stages in self.bodies.items():
            if len(stages) == 1:
                own.setdefault(next(iter(stages)), set()).add(body)
        idle = {stage for stage, bodies in own.items() if not bodies & launched}
        sets = [s - idle if s - idle else s for s in sets]
        known = [next(iter(s)) if len(s) == 1 else None for s in sets]
        told = list(known)
        for i, candidates in enumerate(sets):
            if known[i] is not None:
                continue
            before = next((known[k] for k in range(i - 1, -1, -1) if known[k]), None)
            after = next((known[k] for k in range(i + 1, len(known)) if known[k]), None)
            told[i] = before if before in candidates else after if after in candidates else None
        return told
