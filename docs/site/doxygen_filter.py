#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What Doxygen reads in place of a header: doxygen_filter.py HEADER. Lines keep their numbers.

Every header becomes a Doxygen group, named after the file, which a page shows with ```{doxygengroup}. The comment at the head
of the header documents the group: its first paragraph as text, the rest, with its tables of symbols and formulas, as it
stands. The inline namespace v0 is left out of names. A declaration of several names with one comment becomes several; a comment behind
the head of a function moves in front of it.
"""
import re
import sys
from pathlib import Path

path = Path(sys.argv[1])
group = path.stem
lines = path.read_text(encoding="utf-8").split("\n")
end = 1
while end < len(lines) and lines[end].startswith("//"):
    end += 1
if lines[0].startswith("// SPDX"):
    for number in range(1, end):
        lines[number] = re.sub(r"^// ?", "", lines[number])
    verbatim = "" in lines[1:end]
    if verbatim:
        lines[lines.index("", 1)] = "@verbatim"
    lines[0] = f"/** @defgroup {group} {path.name}"
    # In place of `#pragma once`, which says nothing to Doxygen.
    lines[end] = "@endverbatim */" if verbatim else "*/"
inner = next((m[1] for m in map(re.compile(r"namespace (\w+) \{$").match, lines) if m and m[1] not in ("meltsim", "detail")), "v0")
for number, line in enumerate(lines):
    opened = f"/** @addtogroup {group} */ /** @{{ */"
    if line in ("inline namespace v0 {", f"namespace {inner} {{"):
        kept = "" if "v0" in line else line
        lines[number] = f"{kept} {opened}" if inner in line else kept
    if line in ("}  // namespace v0", f"}}  // namespace {inner}"):
        kept = "" if "v0" in line else "}"
        lines[number] = f"/** @}} */ {kept}" if inner in line else kept
# "T a, b;  ///< both" documents b alone: one declaration each.
name = r"\w+(?:\[\w+\])?(?: = \{\}| = [^,;{}]+|\{[^{}]*\})?"
several = re.compile(rf"^( *)((?:inline |constexpr |const )*[\w:]+(?:<[\w:<>, ]+>)?) ({name}(?:, {name})+); +///< ?(.*)$")
for number, line in enumerate(lines):
    match = several.match(line)
    if match and number + 1 < len(lines) and not lines[number + 1].lstrip().startswith("///<"):
        names = re.findall(rf"{name}(?=, |$)", match[3])
        lines[number] = match[1] + " ".join(f"{match[2]} {one}; /**< {match[4]} */" for one in names)
# "T f(U u) {  ///< what" and "enum class E { a, b };  ///< what": in front, where Doxygen looks for it.
for number, line in enumerate(lines):
    match = re.match(r"^(.*\{| *friend .*\}|enum class .*\};) +///< ?(.*)$", line)
    if match and not re.match(r"^ *(struct|class) ", line):
        first = number
        while first > 0 and not re.match(r"^ *(template|MELTSIM_HD|inline|enum|friend)", lines[first]):
            first -= 1
        if lines[first - 1].startswith("template"):
            first -= 1
        lines[number] = match[1]
        lines[first] = f"/** {match[2]} */ {lines[first]}"
sys.stdout.write("\n".join(lines))
