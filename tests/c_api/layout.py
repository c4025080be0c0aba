# SPDX-License-Identifier: Apache-2.0
"""layout.py HEADER CC LIBRARY [--update]: what C hosts were compiled against, against abi.txt beside this file: the functions that
the library exports, and size and offsets of every struct of the header. Adding lines at the end of a struct, and functions, is
compatible; the list is then written anew with --update. Exit code 1 on a difference."""
import difflib
import re
import subprocess
import sys
import tempfile
from pathlib import Path

header, cc, library = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
text = re.sub(r"/\*.*?\*/", "", header.read_text(encoding="utf-8"), flags=re.S)
lines = ['#include <stdio.h>', '#include "meltsim/meltsim.h"', "int main(void) {"]
for body, name in re.findall(r"typedef struct meltsim_\w+ \{(.*?)\} (meltsim_\w+);", text, flags=re.S):
    lines.append(f'  printf("{name} %u\\n", (unsigned)sizeof({name}));')
    for member in re.findall(r"(\w+)(?:\[\d+\])*;", body):
        lines.append(f'  printf("  {member} %u\\n", (unsigned)offsetof({name}, {member}));')
for value in re.findall(r"\b(MELTSIM_[A-Z_]+) = \d+", text):
    lines.append(f'  printf("{value} %d\\n", {value});')
lines += ["  return 0;", "}"]
with tempfile.TemporaryDirectory() as folder:
    (Path(folder) / "a.c").write_text("\n".join(lines))
    subprocess.run([cc, "-std=c99", "-I", str(header.parent.parent), "-o", f"{folder}/a", f"{folder}/a.c"], check=True)
    now = subprocess.run([f"{folder}/a"], check=True, capture_output=True, text=True).stdout
symbols = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True).stdout
exported = sorted(re.findall(r" T (meltsim_\w+)$", symbols, flags=re.M))
inline = set(re.findall(r"static inline \w+ (meltsim_\w+)\(", text))
declared = sorted(set(re.findall(r"\b(meltsim_\w+)\(", text)) - inline)
if exported != declared:
    sys.exit(f"declared and not exported, or the other way round: {sorted(set(exported) ^ set(declared))}")
# What is passed and returned, and of which type members are: a name and an offset say nothing of either.
calls = {}
for line in re.findall(r"^MELTSIM_C_API ([^;]*?);", text, flags=re.M):
    calls[re.search(r"(meltsim_\w+)\(", line).group(1)] = " ".join(line.split())
now += "".join(f"{calls[name]}\n" for name in exported)
now += "".join(f"{' '.join(line.split())}\n" for line in re.findall(r"typedef (?!struct meltsim_\w+ \{|struct meltsim_\w+ meltsim)[^;{]*;", text))
for body, name in re.findall(r"typedef struct meltsim_\w+ \{(.*?)\} (meltsim_\w+);", text, flags=re.S):
    now += f"{name}: " + " ".join(body.split()) + "\n"
known = Path(__file__).with_name("abi.txt")
if "--update" in sys.argv:
    known.write_text(now)
before = known.read_text() if known.exists() else ""
for line in difflib.unified_diff(before.splitlines(), now.splitlines(), "abi.txt", "now", lineterm=""):
    print(line)
sys.exit(now != before)
