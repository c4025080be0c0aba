# SPDX-License-Identifier: Apache-2.0
"""abi.py HEADER CC [--update]: whether hosts in C that were compiled against abi_baseline.txt, the header of the last version that
could break them, go on to work with HEADER. abidiff (package abigail-tools) says so, of two small libraries whose functions are those
that each declares and do nothing: their debug information is the C interface and nothing else, without a build of the library. That
the library has these functions is for layout.py, and that it defines them as they are declared for the compiler.
New functions, and new members at the end of structs whose size the host says, are compatible. --update writes the baseline anew: where
hosts are to be compiled anew. Exit code 1 on a break, 77 without abidiff."""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

header, cc = Path(sys.argv[1]), sys.argv[2]
baseline = Path(__file__).with_name("abi_baseline.txt")
first_line = "/* SPDX-License-Identifier: Apache-2.0 */\n"


def bare(text):
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    return first_line + "".join(line.rstrip() + "\n" for line in text.splitlines() if line.strip())


def structs(text):
    return {name: [m.strip() for m in body.split(";")[:-1]]
            for body, name in re.findall(r"typedef struct meltsim_\w+ \{(.*?)\} (meltsim_\w+);", text, flags=re.S)}


def as_known(text, before):
    """`text` with those structs cut off that may grow and have: an older host makes, and reads, their beginnings."""
    said = set(re.findall(r"(meltsim_\w+)\* \w+,\s*size_t struct_size", text))
    for name, members in structs(text).items():
        known = before.get(name, members)
        if members[0] == "uint32_t size" or name in said:
            text = re.sub(r"(typedef struct %s \{).*?(\} %s;)" % (name, name),
                          lambda m: m[1] + "".join(f"{member}; " for member in members[:len(known)]) + m[2], text, flags=re.S)
    return text


def library(folder, text):
    (folder / "meltsim").mkdir(parents=True)
    (folder / "meltsim/meltsim.h").write_text(text)
    shutil.copy(header.parent / "version.hpp", folder / "meltsim")
    lines = ['#include "meltsim/meltsim.h"']
    for function in re.findall(r"^MELTSIM_C_API ([^;]*?);", text, flags=re.M):
        lines.append(function + (" {}" if function.startswith("void ") else " { return 0; }"))
    (folder / "calls.c").write_text("\n".join(lines) + "\n")
    subprocess.run([cc, "-std=c99", "-g", "-fno-eliminate-unused-debug-types", "-shared", "-fPIC", "-I", folder, "-o", folder / "libmeltsim.so",
                    folder / "calls.c"], check=True)
    return folder / "libmeltsim.so"


now = bare(header.read_text(encoding="utf-8"))
if "--update" in sys.argv:
    baseline.write_text(now)
before = baseline.read_text()
if shutil.which("abidiff") is None:
    print("SKIPPED: abidiff is not installed (package abigail-tools)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as name:
    was = library(Path(name) / "was", before)
    done = subprocess.run(["abidiff", "--non-reachable-types", "--no-added-syms", was, library(Path(name) / "is", as_known(now, structs(before)))],
                          capture_output=True, text=True)
print(done.stdout + done.stderr, end="")
# Bit 4 of the exit code: a change, structs of new functions among them. What counts is what was there.
summaries = re.findall(r"summary: (\d+) removed, (\d+) changed", done.stdout, flags=re.I)
compatible = done.returncode == 0 or (done.returncode == 4 and summaries and all(s == ("0", "0") for s in summaries))
sys.exit(0 if compatible else 1)
