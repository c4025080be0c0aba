#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what the program says about broken scenes and commands with what it should say, word by word.

  golden_errors.py MELTSIM GOLDEN_DIR COMMANDS_FILE

Each GOLDEN_DIR/*.yaml ends in comments: `#> args ...` (options), `#> exit N`, and one `#> line` per line of
stderr; a line that starts with `~` is a regular expression. Without such a line only the exit code counts.
"""
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path


def matches(expected, actual):
    if not expected:
        return actual != ""
    if len(expected) != len(actual.splitlines()):
        return False
    return all(re.fullmatch(e[1:], a) if e.startswith("~") else e == a
               for e, a in zip(expected, actual.splitlines()))


def run(program, arguments, directory):
    result = subprocess.run([program, *arguments], cwd=directory, capture_output=True, text=True, timeout=120,
                            stdin=subprocess.DEVNULL)
    return result.returncode, result.stderr


def scene_cases(directory):
    for path in sorted(directory.glob("*.yaml")):
        arguments, code, expected = ["check", path.name], None, []
        for line in path.read_text().splitlines():
            if line.startswith("#> args "):
                arguments += shlex.split(line[8:])
            elif line.startswith("#> exit "):
                code = int(line[8:])
            elif line.startswith("#> "):
                expected.append(line[3:])
        yield path.name, arguments, code, expected


def command_cases(path):
    for block in re.split(r"\n\s*\n", path.read_text()):
        lines = [line for line in block.splitlines() if line and not line.startswith("#")]
        if lines:
            yield lines[0], shlex.split(lines[0][2:]), int(lines[1]), lines[2:]


def main():
    program, golden, commands = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    bad = total = 0
    with tempfile.TemporaryDirectory() as empty:
        cases = [(golden, *case) for case in scene_cases(golden)] + \
                [(empty, *case) for case in command_cases(commands)]
        for directory, name, arguments, code, expected in cases:
            total += 1
            got_code, got = run(program, arguments, directory)
            if got_code != code or not matches(expected, got):
                bad += 1
                print(f"{name}\n  expected {code}: " + "\n    ".join(expected) + f"\n  got      {got_code}: {got}")
        left = list(Path(empty).iterdir())
        if left:
            bad += 1
            print(f"refused commands left files behind: {left}")
    print(f"{total - bad} of {total} as expected")
    return 1 if bad or total == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
