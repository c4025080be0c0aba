#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""meltsim-view as users start it: pictures under a virtual display, and what it says without one.

  window_test.py PROGRAM SCENE     exit code 77 where PROGRAM or Xvfb is missing
"""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "runner"))
from png_reader import read_png  # noqa: E402

SKIPPED = 77


class Display:
    """An X server of its own; it picks a free number."""

    def __enter__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp"],
                                       pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.name = ":" + number.readline().strip()
        assert self.name != ":", "Xvfb did not start"
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


def run(program, arguments, display):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment.update(LIBGL_ALWAYS_SOFTWARE="1", XDG_RUNTIME_DIR="/nonexistent")
    if display:
        environment["DISPLAY"] = display
    return subprocess.run([program, *arguments], env=environment, capture_output=True, text=True, timeout=200)


def picture(program, scene, display, directory, *arguments):
    file = Path(directory) / "picture.png"
    file.unlink(missing_ok=True)
    done = run(program, [scene, "--backend", "cpu", "--threads", "1", "--size", "640x480", "--screenshot", str(file),
                         *arguments], display)
    assert done.returncode == 0, f"{arguments}: code {done.returncode}\n{done.stdout}{done.stderr}"
    width, height, rows = read_png(file)
    assert (width, height) == (640, 480), (width, height)
    return rows


def share(rows, is_color):
    """Of the pixels above the legend."""
    hits = total = 0
    for row in rows[:390:2]:
        for pixel in row[::2]:
            hits += is_color(*pixel)
            total += 1
    return hits / total


# Light changes how bright a colour is, hardly its hue; backdrop and floor are grey.
def red(r, g, b):
    return r > 70 and r > 2.5 * g and r > 2 * b


def blue(r, g, b):
    return b > 70 and b > 1.9 * r


def pale(r, g, b):
    return min(r, g, b) > 165


def no_color(r, g, b):
    return max(r, g, b) - min(r, g, b) < 40


def check_pictures(program, scene, display, directory):
    def expect(what, value, low, high):
        assert low <= value <= high, f"{what}: {value:.3f} of the picture, expected {low} to {high}"
        print(f"{what}: {value:.3f}")

    hot = ["--no-panel", "--frames", "2", "--set", "fluids[0].temperature=90"]
    rows = picture(program, scene, display, directory, *hot, "--color", "temperature")
    expect("hot water is red", share(rows, red), 0.04, 0.6)
    expect("cold ice is blue", share(rows, blue), 0.005, 0.3)
    expect("the rest is grey", share(rows, no_color), 0.3, 0.95)

    cold = ["--no-panel", "--frames", "2", "--set", "fluids[0].temperature=-9", "--set", "emitters[0].from=0.4"]
    rows = picture(program, scene, display, directory, *cold, "--color", "temperature")
    expect("no red without heat", share(rows, red), 0, 0.001)

    rows = picture(program, scene, display, directory, *hot, "--color", "phase")
    expect("liquid is blue", share(rows, blue), 0.04, 0.6)
    expect("solid is pale", share(rows, pale), 0.005, 0.3)

    rows = picture(program, scene, display, directory, "--after", "0.1")
    expect("a panel is dark", share(rows, lambda r, g, b: max(r, g, b) < 50), 0.2, 0.9)


def check_errors(program, scene, display, directory):
    def expect(arguments, code, words, on_display=True):
        done = run(program, arguments, display if on_display else None)
        assert done.returncode == code, f"{arguments}: code {done.returncode}, expected {code}\n{done.stderr}"
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
        for word in words:
            assert word in done.stderr, f"{arguments}: \"{word}\" is not in\n{done.stderr}"

    expect([scene], 4, ["no display", "meltsim run"], on_display=False)
    expect([scene, "--set", "materials.ice.densty=1"], 2, ["densty", "density"], on_display=False)
    expect(["no_such_scene"], 1, ["no_such_scene"], on_display=False)
    expect([scene, "--colour", "phase"], 1, ["--color"])
    expect([scene, "--color", "fase"], 1, ["phase"])
    expect([scene, "--size", "big"], 1, ["WIDTHxHEIGHT"])
    expect([scene, "--frames", "1", "--screenshot", directory + "/none/a.png"], 5, ["cannot be written"])
    expect([scene, "--frames", "1", "--set", "particles.spacing=1.5"], 2, ["domain"])


def main(program, scene):
    if not os.access(program, os.X_OK):
        print("SKIPPED: the viewer was not built")
        return SKIPPED
    if shutil.which("Xvfb") is None:
        print("SKIPPED: no Xvfb (Debian/Ubuntu: apt install xvfb libgl1-mesa-dri)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as directory, Display() as display:
        check_pictures(program, scene, display.name, directory)
        check_errors(program, scene, display.name, directory)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
