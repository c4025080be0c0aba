#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""index.html: what it holds is what the frames hold; in a browser it shows that.

  replay_page.py MELTSIM SCENE data|browser

`browser` needs Chromium and ends with 77 (skipped) where there is none.
"""
import base64
import html
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

sys.path.insert(0, os.path.dirname(__file__))
from png_reader import linear, monitor, read_png  # noqa: E402

PROGRAM, SCENE, PART = str(Path(sys.argv[1]).resolve()), str(Path(sys.argv[2]).resolve()), sys.argv[3]
BROWSER = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))),
               None)
BROWSER_COMMAND = [BROWSER, "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                   "--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=900,600", "--virtual-time-budget=4000"]


# Marks of the template, ends and beginnings of scripts and comments, escapes.
ODD_TITLES = ["</script><b>x", "%FRAMES%", "%META%", "<!--<script>", "<!-- <script", "]]> -->", "\\u003c\\ \"'`${1}", "\u2028 \U0001f525"]


def part(page, name):
    return re.search(rf'<script id="{name}"[^>]*>(.*?)</script>', page, re.S).group(1)


def unpacked(page):
    """[(time, {id: (x, y, z, temperature, look, material)})], as the page's own script reads it."""
    run = json.loads(part(page, "about-run"))
    data, at, before, frames = zlib.decompress(base64.b64decode(part(page, "frames"))), 0, {}, []
    low, high = run["temperature"]
    for frame in run["frames"]:
        n, ids, last = frame["n"], [], -1
        for _ in range(n):
            gap = shift = 0
            while True:
                byte = data[at]
                at += 1
                gap |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    break
            last += 1 + gap
            ids.append(last)
        columns = []
        for axis in range(3):
            zigzag = [data[at + i] | data[at + n + i] << 8 for i in range(n)]
            columns.append([(before.get(k, (0,) * 5)[axis] + (z >> 1 ^ -(z & 1))) & 65535 for k, z in zip(ids, zigzag)])
            at += 2 * n
        columns.append([(data[at + i] + before.get(k, (0,) * 5)[3]) & 255 for i, k in enumerate(ids)])
        columns.append([data[at + n + i] ^ before.get(k, (0,) * 6)[4] for i, k in enumerate(ids)])
        columns.append([data[at + 2 * n + i] ^ before.get(k, (0,) * 6)[5] for i, k in enumerate(ids)])
        at += 3 * n
        before = dict(zip(ids, zip(*columns)))
        frames.append((frame["time"], {
            k: (*(run["min"][a] + run["step"][a] * v[a] for a in range(3)), low + (high - low) * v[3] / 255,
                *v[4:])
            for k, v in before.items()}))
    assert at == len(data), "bytes are left over"
    return run, frames


def read_ply(path):
    data = Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    return list(struct.iter_unpack("<7fBiIif", data[end:]))


class Page(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory()
        self.addCleanup(self.directory.cleanup)
        self.run_scene("--frames", "3")

    def run_scene(self, *options):
        subprocess.run([PROGRAM, "run", SCENE, "--backend", "cpu", "--out", "run", "--overwrite", "--quiet", *options],
                       cwd=self.directory.name, check=True, timeout=300)
        self.file = Path(self.directory.name, "run", "index.html")
        self.page = self.file.read_text()


class Data(Page):
    def test_nothing_comes_from_elsewhere(self):
        self.assertLess(len(self.page), 10e6)
        self.assertEqual(re.findall(r"https?://|src=|@import|<link", self.page), [])

    def test_frames_are_those_of_the_run(self):
        run, frames = unpacked(self.page)
        self.assertEqual([round(time, 9) for time, _ in frames], [0, 0.04, 0.08, 0.12])
        degree = (run["temperature"][1] - run["temperature"][0]) / 255
        for index, (_, particles) in enumerate(frames):
            written = read_ply(Path(self.directory.name, "run", "frames", f"particles_{index:05}.ply"))
            self.assertEqual(len(written), len(particles))
            for x, y, z, _, _, _, temperature, phase, body, number, material, _ in written:
                shown = particles[number]
                for a, b in zip(shown, (x, y, z)):
                    self.assertLess(abs(a - b), 0.2 / 100 * 1.01)  # half of a 50th of the spacing
                self.assertLess(abs(shown[3] - temperature), 0.51 * degree)
                self.assertEqual(shown[4], 128 * phase + body + 1)
                self.assertEqual(shown[5], material)
                self.assertEqual(run["materials"][material]["name"], "ice" if phase == 1 else "water")

    def test_mixtures_have_mixed_colours(self):
        """Half milk: 16 of the 31 steps that a content has. Light adds up: as linear light (sRGB), then back."""
        milk = "{dissolves_in: water, diffusivity_in: 1e-9, color: [1, 0.9, 0.8]}"
        self.run_scene("--frames", "1", "--set", "materials.milk=" + milk, "--set", "materials.water.color=[0.2, 0.1, 0.05]",
                       "--set", "fluids[0].fractions={milk: 0.5}")
        run, frames = unpacked(self.page)
        self.assertEqual(run["dissolved"], [{"name": "milk", "color": [255, 230, 204]}])
        seen = {p[5] for p in frames[0][1].values() if p[4] < 128}
        mixtures = [run["materials"][number] for number in seen if "of" in run["materials"][number]]
        self.assertEqual(len(mixtures), 1)
        self.assertEqual(mixtures[0]["name"], "water")
        self.assertEqual(run["materials"][mixtures[0]["of"]]["name"], "water")
        for shown, a, b in zip(mixtures[0]["color"], (1, 0.9, 0.8), (0.2, 0.1, 0.05)):
            share = 16 / 31
            self.assertAlmostEqual(shown / 255, monitor(share * linear(a) + (1 - share) * linear(b)), delta=0.51 / 255)

    def test_solids_without_a_colour_have_those_of_pictures(self):
        """Pictures colour bodies one after another; a material has the colour of its first body."""
        box = "{shape: {box: [[%s, 0.8, 0.4], [%s, 1.2, 0.8]]}, material: %s}"
        self.run_scene("--frames", "1", "--set", "materials.clay={density: 2000}", "--set", "materials.wax={density: 900, color: [1, 0.5, 0]}",
                       "--set", "bodies=[" + ", ".join(box % at for at in (("0", "0.4", "ice"), ("0.4", "0.8", "wax"), ("0.8", "1.2", "clay"),
                                                                           ("1.2", "1.6", "ice"))) + "]")
        materials = {m["name"]: m for m in unpacked(self.page)[0]["materials"]}
        for name, light in (("ice", (0.66, 0.80, 0.90)), ("clay", (0.64, 0.15, 0.10))):  # the first and the third
            self.assertIsNone(materials[name]["color"])
            self.assertEqual(materials[name]["solid"], [round(255 * monitor(c)) for c in light])
        self.assertEqual((materials["wax"]["color"], "solid" in materials["wax"], "solid" in materials["water"]), ([255, 128, 0], False, False))

    def test_nothing_to_see_makes_a_page(self):
        self.run_scene("--set", "fluids=[]", "--set", "bodies=[]", "--set", "emitters=[]", "--export", "none", "--frames", "3")
        run, frames = unpacked(self.page)
        self.assertEqual([len(particles) for _, particles in frames], [0] * 4)
        self.assertEqual(run["stats"]["rows"][0][0], 0)

    def test_an_empty_scene_has_no_temperature(self):
        """A jet that begins at 0.06 s fills a scene that has no particle at 0 and 0.04 s."""
        self.run_scene("--set", "fluids=[]", "--set", "bodies=[]", "--set", "emitters[0].from=0.06", "--export", "none",
                       "--frames", "4")
        stats = unpacked(self.page)[0]["stats"]
        for name in ("T_min", "T_mean", "T_max"):
            self.assertEqual([row[stats["columns"].index(name)] for row in stats["rows"]], [None, None, 90, 90, 90])

    def test_a_title_cannot_end_the_script(self):
        for title in ODD_TITLES:
            with self.subTest(title=title):
                self.run_scene("--frames", "1", "--set", "title=" + json.dumps(title, ensure_ascii=False))
                self.assertEqual(json.loads(part(self.page, "about-run"))["title"], title)
                self.assertEqual(len(unpacked(self.page)[1]), 2)


class Browser(Page):
    def setUp(self):
        super().setUp()
        self.run_scene("--frames", "3", "--set", "emitters=[]")  # then the water is what is hottest

    def pixels(self, wish):
        picture = Path(self.directory.name, "page.png")
        picture.unlink(missing_ok=True)
        done = subprocess.run(
            [*BROWSER_COMMAND, f"--user-data-dir={self.directory.name}/profile", f"--screenshot={picture}",
             f"file://{self.file}#{wish}"], capture_output=True, text=True, timeout=180)
        self.assertTrue(picture.exists(), done.stderr)
        _, _, rows = read_png(picture)
        # Panels have colours of their own: look at the middle of the picture.
        return [pixel for row in rows[80:390] for pixel in row[280:660]]

    def test_it_shows_hot_water_and_cold_ice(self):
        hot = [p for p in self.pixels("t=0.04&color=temperature") if p[0] > p[2] + 60]
        solid = self.pixels("t=0.04&color=temperature&liquid=hidden")
        cold = [p for p in solid if p[2] > p[0] + 60]
        # Of 117,800: the scene fills a good part of the picture.
        self.assertGreater(len(hot), 2000)
        self.assertGreater(len(cold), 500)
        without = [p for p in solid if p[0] > p[2] + 60]
        self.assertLess(len(without), len(hot) / 10)

    def test_any_title_leaves_the_page_alive(self):
        for title in ODD_TITLES[:4]:
            with self.subTest(title=title):
                self.run_scene("--frames", "1", "--set", "title=" + json.dumps(title, ensure_ascii=False))
                shown = subprocess.run([*BROWSER_COMMAND, f"--user-data-dir={self.directory.name}/profile", "--dump-dom",
                                        f"file://{self.file}"], capture_output=True, text=True, timeout=180).stdout
                # The page's script writes the title where it can read what is in the page, and a message where it cannot.
                self.assertEqual(html.unescape(re.search(r'<b id="title">(.*?)</b>', shown, re.S).group(1)), title)
                self.assertNotIn("display", re.search(r'<div id="message".*?>', shown).group(0))

    def test_names_of_curves_keep_clear_of_titles(self):
        """Plots are 225 pixels wide here: title and names of the energies are longer than that side by side."""
        self.pixels("t=0.04")
        _, _, rows = read_png(Path(self.directory.name, "page.png"))
        plots = [[row[452:672] for row in rows[-150 + top:-150 + top + 14]] for top in (5, 19)]  # the third of four
        kinetic = [sum(p[1] > p[0] + 60 and p[1] > p[2] + 40 for row in part for p in row) for part in plots]
        self.assertEqual(kinetic[0], 0)  # beside the title
        self.assertGreater(kinetic[1], 20)  # below it: seven letters

    def test_materials_have_the_scene_s_colours(self):
        self.run_scene("--frames", "3", "--set", "materials.water.color=[0.1, 0.8, 0.1]")
        shown = self.pixels("t=0.04&color=material")
        self.assertGreater(len([p for p in shown if p[1] > p[0] + 60 and p[1] > p[2] + 60]), 2000)

    def test_phases_have_their_colours(self):
        shown = self.pixels("t=0.04&color=phase")
        self.assertGreater(len([p for p in shown if p[2] > p[0] + 60]), 2000)
        self.assertGreater(len([p for p in shown if min(p) > 120 and max(p) - min(p) < 40]), 200)


if __name__ == "__main__":
    if PART == "browser" and BROWSER is None:
        print("SKIPPED: no chromium here (Debian: apt install chromium)")
        sys.exit(77)
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(Browser if PART == "browser" else Data)
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful())
