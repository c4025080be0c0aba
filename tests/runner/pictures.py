#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Surfaces, pictures, movies and plots: written, and read back by readers that are not ours.

  pictures.py MELTSIM SCENE own|vtk|povray|movie|plot

All parts but `own` need a program and end with 77 (skipped) where there is none.
"""
import collections
import csv
import json
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, os.path.dirname(__file__))
from mesh_reader import read_glb, read_mesh, read_obj  # noqa: E402
from png_reader import linear, read_png  # noqa: E402

PROGRAM, SCENE, PART = str(Path(sys.argv[1]).resolve()), str(Path(sys.argv[2]).resolve()), sys.argv[3]
MELT = ["--set", "heat.time_scale=1e7", "--set", "time.end_when=melted", "--set", "time.end=20"]
DRY = ["--set", "fluids=[]", "--set", "emitters=[]"]


def colors(path):
    _, _, rows = read_png(path)
    return collections.Counter(pixel for row in rows for pixel in row)


class Pictures(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.TemporaryDirectory()
        self.addCleanup(self.directory.cleanup)

    def path(self, *parts):
        return os.path.join(self.directory.name, *parts)

    def meltsim(self, *arguments, code=0, **options):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.directory.name, capture_output=True, text=True,
                              timeout=300, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def run_scene(self, *options, **more):
        return self.meltsim("run", SCENE, "--backend", "cpu", "--out", "run", *options, **more)

    def frame(self, name):
        return self.path("run", "frames", name)


class Own(Pictures):
    def assert_closed(self, mesh, may_end):
        """may_end: in a solid, as liquid does."""
        edges = collections.Counter()
        for a, b, c in mesh.faces:
            for edge in ((a, b), (b, c), (c, a)):
                edges[edge] += 1
        self.assertTrue(all(n == 1 and (may_end or edges[(b, a)] == 1) for (a, b), n in list(edges.items())))

    def test_surfaces_hold_what_the_frame_holds(self):
        self.run_scene("--frames", "2", "--export", "surface,obj,glb")
        for index in range(3):
            nodes = read_glb(self.frame(f"surface_{index:05}.glb"))
            for name, body in (("liquid", -1), ("solid", 0)):
                mesh = read_mesh(self.frame(f"{name}_{index:05}.ply"))
                self.assertFalse(mesh.placeholder)
                self.assertGreater(len(mesh.faces), 100)
                self.assert_closed(mesh, name == "liquid")
                for x, y, z, nx, ny, nz, temperature, owner, material, fraction in mesh.vertices:
                    self.assertTrue(-0.2 < x < 1.8 and -0.2 < y < 2.2 and -0.2 < z < 1.8)
                    self.assertAlmostEqual(math.hypot(nx, ny, nz), 1, places=4)
                    self.assertTrue(-10.1 < temperature < 90.1)
                    self.assertEqual(owner, body)
                    self.assertEqual(material, body + 1)  # water, then ice
                    self.assertTrue(0 <= fraction <= 1)
                # Outward, and counter-clockwise from there: the volume they enclose is positive.
                volume = 0
                for a, b, c in mesh.faces:
                    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (mesh.vertices[i][:3] for i in (a, b, c))
                    volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6
                n = {"liquid": 192, "solid": 32}[name]  # and a nozzle's worth
                self.assertTrue(0.6 * n * 0.2 ** 3 < volume < 1.6 * n * 0.2 ** 3, (name, volume))
                positions, shades, temperatures, normals, faces = read_obj(self.frame(f"{name}_{index:05}.obj"))
                self.assertEqual(faces, mesh.faces)
                self.assertTrue(all(0 <= c <= 1 for shade in shades for c in shade))
                glb = nodes[name]
                self.assertEqual(glb["indices"], [i for face in faces for i in face])
                for i, vertex in enumerate(mesh.vertices):
                    for axis in range(3):
                        self.assertAlmostEqual(positions[i][axis], vertex[axis], places=5)
                        self.assertAlmostEqual(normals[i][axis], vertex[3 + axis], places=4)
                        self.assertAlmostEqual(glb["POSITION"][i][axis] + glb["translation"][axis], vertex[axis],
                                               places=5)
                    self.assertAlmostEqual(temperatures[i], vertex[6], delta=1e-4 * (1 + abs(vertex[6])))
                    self.assertEqual(glb["_TEMPERATURE"][i][0], vertex[6])
                    self.assertEqual(glb["_BODY"][i][0], vertex[7])
                    self.assertEqual(glb["_MATERIAL"][i][0], vertex[8])
                    self.assertEqual(glb["_LIQUID_FRACTION"][i][0], vertex[9])

    def test_materials_show_their_colours(self):
        """Water of a colour is opaque: red all over, whatever the renderer; a part of its own in glTF."""
        red = ["--set", "materials.water.color=[0.8, 0.1, 0.1]", "--set", "output.picture.look=natural"]
        shares = []
        for options in ([], red):
            self.run_scene("--frames", "1", "--export", "surface,obj,glb,png,ply", "--overwrite", *options)
            glb = read_glb(self.frame("surface_00001.glb"))
            name, factor, by_vertex, _ = glb["liquid"]["parts"][0]
            self.assertEqual((name, by_vertex), ("water" if options else "liquid", False))
            extensions = glb["liquid"]["materials"][name].get("extensions")
            if options:
                for c, wanted in zip(factor, (linear(0.8), linear(0.1), linear(0.1), 1)):
                    self.assertAlmostEqual(c, wanted, places=6)
                self.assertIsNone(extensions)
            else:
                self.assertEqual(extensions, {"KHR_materials_transmission": {"transmissionFactor": 1},
                                              "KHR_materials_ior": {"ior": 1.333}})
                self.assertEqual(factor[3], 1)
            self.assertEqual([part[:3] for part in glb["solid"]["parts"]], [("ice", [0.66, 0.8, 0.9, 1], False)])
            self.assertIn("\nusemtl water\n", Path(self.frame("liquid_00001.obj")).read_text())
            counts = []

            def count(file):
                counts.append(sum(n for (r, g, b), n in colors(file).items() if r > 2 * max(g, b)))

            def render():
                self.meltsim("render", "run", "--renderer", "builtin", "--pictures", "1", "--size", "64x36")
                written, = Path(self.path("run", "pictures")).glob("*.png")
                count(written)
                os.remove(written)

            count(self.frame("picture_00001.png"))
            render()
            os.remove(self.frame("liquid_00001.ply"))
            os.remove(self.frame("liquid_00000.ply"))
            render()  # particles as balls
            shares.append(counts)
        for clear, opaque in zip(*shares):
            self.assertLess(clear, 10)
            self.assertGreater(opaque, 200)

    def test_gltf_shows_temperatures_where_pictures_do(self):
        self.run_scene("--frames", "0", "--export", "glb,surface", "--set", "output.picture.look=temperature")
        nodes = read_glb(self.frame("surface_00000.glb"))
        for name, temperature, blue in (("liquid", 40, None), ("solid", -10, linear(0.14))):
            self.assertEqual([(part[0], part[2]) for part in nodes[name]["parts"]], [(name, True)])
            self.assertTrue(all(abs(row[0] - temperature) < 1e-3 for row in nodes[name]["_TEMPERATURE"]))
            red = nodes[name]["COLOR_0"][0][0]
            self.assertTrue(red > 0.5 if name == "liquid" else abs(red - blue) < 1e-4, red)
        self.assertNotIn("extensions", nodes["liquid"]["materials"]["liquid"])

    def test_bodies_of_one_material_have_colours_of_their_own(self):
        self.run_scene("--frames", "0", *DRY, "--export", "glb", "--set",
                       "bodies=[{material: ice, shape: {box: [[0.2, 0.2, 0.2], [0.6, 0.6, 0.6]]}},"
                       " {material: ice, shape: {box: [[1, 1, 1], [1.4, 1.4, 1.4]]}}]")
        solid = read_glb(self.frame("surface_00000.glb"))["solid"]
        self.assertEqual([part[:2] for part in solid["parts"]], [("ice", [0.66, 0.8, 0.9, 1]), ("ice_2", [0.8, 0.42, 0.09, 1])])
        for body, (_, _, _, indices) in enumerate(solid["parts"]):
            self.assertEqual({solid["_BODY"][v][0] for v in indices}, {body})

    def test_a_liquid_is_closed_at_solids_where_the_scene_says_so(self):
        for closed in (False, True):
            self.run_scene("--frames", "0", "--export", "surface", "--overwrite", "--set", "bodies[0].shape.box=[[0.4, 0.4, 0.4], [1.2, 0.8, 1.2]]",
                           "--set", f"output.surface.closed_at_solids={str(closed).lower()}")
            mesh = read_mesh(self.frame("liquid_00000.ply"))
            self.assert_closed(mesh, not closed)
            edges = {(f[k], f[(k + 1) % 3]) for f in mesh.faces for k in range(3)}
            self.assertEqual(all((b, a) in edges for a, b in edges), closed)

    def test_beside_bodies_left_out_every_vertex_has_a_triangle(self):
        self.run_scene("--frames", "4", "--export", "surface", "--set",
                       "bodies=[{name: pot, visible: false, fixed: true, material: ice, shape: {box: [[0, 0, 0], [1.6, 0.4, 1.6]]}},"
                       " {name: float, material: ice, shape: {box: [[0.4, 0.4, 0.4], [1, 1, 1]]}}]",
                       "--set", "fluids[0].shape.box=[[0, 0.4, 0], [1.6, 1, 1.6]]")
        for index in range(5):
            mesh = read_mesh(self.frame(f"liquid_{index:05}.ply"))
            self.assertEqual({v for face in mesh.faces for v in face}, set(range(len(mesh.vertices))))

    def test_against_gravity_is_up_in_gltf(self):
        """glTF's +y: the file of a scene whose gravity is along another axis is turned there."""
        for gravity, wanted in (([0, -9.81, 0], None), ([0, 0, -9.81], [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]),
                                ([-9.81, 0, 0], [0, 0, math.sqrt(0.5), math.sqrt(0.5)]), ([0, 9.81, 0], [1, 0, 0, 0])):
            self.run_scene("--frames", "0", "--export", "glb,usd", "--overwrite", "--set", f"solver.gravity={gravity}")
            nodes = read_glb(self.frame("surface_00000.glb"))
            self.assertEqual(set(nodes), {"liquid", "solid"})
            for node in nodes.values():
                self.assertEqual(node["rotation"] is None, wanted is None)
                for a, b in zip(node["rotation"] or [], wanted or []):
                    self.assertAlmostEqual(a, b)
            text = Path(self.frame("scene.00000.usda")).read_text()
            self.assertEqual(text.count("primvars:liquid_fraction ("), 3)  # of particles, liquid and solids
            self.assertEqual(("upAxis = \"Z\"" in text, "xformOp" in text), (gravity[2] != 0, gravity[2] == 0 and wanted is not None))

    def test_a_frame_without_solids_or_without_liquid_is_whole_too(self):
        for options, missing, there in ((MELT, "solid", "liquid"), (DRY + ["--frames", "1"], "liquid", "solid")):
            self.run_scene(*options, "--export", "surface,obj,glb,png,pov", "--overwrite")
            last = json.loads(Path(self.path("run", "run.json")).read_text())["final"]["frames"] - 1
            mesh = read_mesh(self.frame(f"{missing}_{last:05}.ply"))
            self.assertTrue(mesh.placeholder)
            self.assertEqual(len(mesh.faces), 1)
            self.assertEqual(len(read_obj(self.frame(f"{missing}_{last:05}.obj"))[4]), 1)
            self.assertFalse(read_mesh(self.frame(f"{there}_{last:05}.ply")).placeholder)
            self.assertIn(f"{missing} placeholder", read_glb(self.frame(f"surface_{last:05}.glb")))
            self.assertGreater(len(colors(self.frame(f"picture_{last:05}.png"))), 50)
            self.meltsim("render", "run", "--renderer", "builtin", "--pictures", "1")

    def test_every_run_ends_in_a_picture(self):
        self.run_scene("--frames", "1", "--export", "none", "--set", "emitters=[]")
        self.assertFalse(os.path.exists(self.path("run", "still.png")))  # none is none
        self.run_scene("--frames", "1", "--export", "html", "--set", "output.picture.look=temperature",
                       "--set", "emitters=[]", "--overwrite")
        width, height, _ = read_png(self.path("run", "still.png"))
        self.assertEqual((width, height), (64, 36))
        shown = colors(self.path("run", "still.png"))
        self.assertGreater(sum(n for (r, _, b), n in shown.items() if b > r + 50), 10)  # ice at -10
        self.assertGreater(sum(n for (r, _, b), n in shown.items() if r > b + 50), 50)  # water at 40
        self.assertEqual(os.listdir(self.path("run", "frames")), [])

    def test_a_run_ends_without_a_picture_where_none_is_wanted(self):
        for options in (["--export", "none"], ["--no-still"]):
            shutil.rmtree(self.path("run"), ignore_errors=True)
            self.run_scene("--frames", "1", *options)
            self.assertFalse(os.path.exists(self.path("run", "still.png")))
            self.assertTrue(os.path.exists(self.path("run", "index.html")))
        for still in ([], ["--no-still"]):
            shutil.rmtree(self.path("run"), ignore_errors=True)
            self.run_scene("--frames", "1", "--no-page", *still)
            self.assertEqual(os.path.exists(self.path("run", "still.png")), not still)
            self.assertFalse(os.path.exists(self.path("run", "index.html")))

    def test_the_still_is_half_molten(self):
        """At the end nothing red is left: red ice becomes clear water."""
        self.run_scene(*MELT, "--set", "heat.time_scale=2e6", "--export", "html", "--set", "emitters=[]",
                       "--set", "materials.ice.color=[0.9, 0.05, 0.05]", "--set", "output.picture.look=natural")
        final = json.loads(Path(self.path("run", "run.json")).read_text())["final"]
        self.assertEqual(final["n_solid"], 0)
        red = sum(n for (r, g, b), n in colors(self.path("run", "still.png")).items() if r > 2 * max(g, b))
        self.assertGreater(red, 5)  # of 64 x 36

    def test_the_still_of_few_frames_is_of_the_one_nearest_to_half(self):
        """Shares of 0.13, 0.63, 0.88 and 1 in the last frames: two frames on from half nothing red is left."""
        options = ["--frames", "5", "--set", "time.fps=5", "--set", "heat.time_scale=2e6", "--export", "html",
                   "--set", "emitters=[]", "--set", "materials.ice.color=[0.9, 0.05, 0.05]",
                   "--set", "output.picture.look=natural"]

        def still():
            return Path(self.path("run", "still.png")).read_bytes()

        self.run_scene(*options)
        with open(self.path("run", "stats.csv"), newline="") as file:
            shares = [float(row["melted_fraction"]) for row in csv.DictReader(file)]
        nearest = min(range(6), key=lambda k: abs(shares[k] - 0.5))
        self.assertLess(nearest, 4)
        self.assertTrue(0.3 < shares[nearest] < 0.7 and shares[-1] == 1, shares)
        whole = still()
        self.assertGreater(sum(n for (r, g, b), n in colors(self.path("run", "still.png")).items()
                               if r > 2 * max(g, b)), 5)
        # A run that is interrupted has the picture of what it has seen; it ends with that of a run that is not.
        for frame in (nearest - 1, nearest, nearest + 1):
            shutil.rmtree(self.path("run"))
            process = subprocess.Popen([PROGRAM, "run", SCENE, "--backend", "cpu", "--out", "run", *options, "--export", "ply"],
                                       cwd=self.directory.name, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while process.poll() is None and not os.path.exists(self.frame(f"particles_{frame:05}.ply")):
                time.sleep(0.001)
            process.send_signal(signal.SIGINT)
            if process.wait(timeout=120) != 0:
                self.run_scene(*options, "--export", "ply", "--resume")
            self.assertEqual(still(), whole, frame)

    def test_nothing_at_all_is_a_picture_of_the_floor(self):
        self.run_scene("--frames", "1", *DRY, "--set", "bodies=[]", "--export", "surface,obj,glb,pov,png,ply,vtp")
        self.assertGreater(len(colors(self.path("run", "still.png"))), 5)
        self.meltsim("render", "run", "--renderer", "builtin")

    def test_render_draws_surfaces_and_particles(self):
        self.run_scene("--frames", "4", "--export", "ply,surface")
        size = ["--renderer", "builtin", "--size", "80x60", "--samples", "1"]
        said = self.meltsim("render", "run/", *size, "--pictures", "3", "--look", "temperature")
        self.assertNotIn("balls", said.stderr)
        self.assertEqual(sorted(os.listdir(self.path("run", "pictures")))[1:],  # behind .lock
                         [f"temperature_{i:05}.png" for i in (0, 2, 4)])
        width, height, _ = read_png(self.path("run", "temperature_sheet.png"))
        self.assertEqual((width, height), (3 * 84 + 4, 68))
        shown = colors(self.path("run", "pictures", "temperature_00004.png"))
        self.assertGreater(sum(n for (r, _, b), n in shown.items() if b > r + 50), 20)
        # Without the surfaces: balls, and that is said.
        for name in os.listdir(self.path("run", "frames")):
            if not name.startswith("particles"):
                os.remove(self.frame(name))
        said = self.meltsim("render", "run", *size, "--pictures", "1")
        self.assertIn("drawn as balls", said.stderr)
        self.assertGreater(len(colors(self.path("run", "pictures", "natural_00004.png"))), 100)
        Path(self.frame("particles_00004.ply")).write_bytes(Path(self.frame("particles_00004.ply")).read_bytes()[:-1])
        self.assertIn("particles_00004.ply: is not a whole file", self.meltsim("render", "run", *size, code=5).stderr)

    def test_render_runs_a_scene(self):
        said = self.meltsim("render", SCENE, "--backend", "cpu", "--time", "0.04", "--renderer", "builtin").stdout
        self.assertIn("out/tiny-001/natural_sheet.png", said)
        self.assertTrue(os.path.exists(self.path("out", "tiny-001", "pictures", "natural_00001.png")))

    def test_render_shows_what_is_dissolved(self):
        """The pictures of `render`, of a directory and of a scene, are those of the run: white with milk, not black as coffee."""
        scene = self.path("coffee.json")
        Path(scene).write_text(json.dumps({
            "meltsim": 1, "domain": {"min": [0, 0, 0], "max": [0.06, 0.06, 0.06]}, "particles": {"spacing": 0.005},
            "time": {"end": 0.02, "fps": 50},
            "materials": {"coffee": {"density": 1000, "color": [0.05, 0.03, 0.01]},
                          "milk": {"density": 1030, "dissolves_in": "coffee", "diffusivity_in": 1e-9, "color": [0.95, 0.93, 0.88]}},
            "fluids": [{"shape": {"box": [[0, 0, 0], [0.06, 0.03, 0.06]]}, "material": "coffee", "fractions": {"milk": 0.9}}],
            "output": {"picture": {"width": 64, "height": 36}, "camera": {"eye": [0.03, 0.15, 0.2], "look_at": [0.03, 0.02, 0.03]}}}))
        self.meltsim("run", scene, "--backend", "cpu", "--out", "run", "--export", "surface,png,glb")
        self.meltsim("render", "run", "--renderer", "builtin")
        self.meltsim("render", scene, "--backend", "cpu", "--renderer", "builtin", "--out", "rendered")
        _, _, own = read_png(self.frame("picture_00001.png"))
        self.assertGreater(min(own[22][32]), 120, own[22][32])
        for directory in ("run", "rendered"):
            _, _, rows = read_png(self.path(directory, "pictures", "natural_00001.png"))
            self.assertLess(max(abs(a - b) for a, b in zip(rows[22][32], own[22][32])), 12, directory)
        # In glTF vertices carry the colours of mixtures, also where nothing of the liquid is clear.
        liquid = read_glb(self.frame("surface_00001.glb"))["liquid"]
        self.assertEqual([(name, by_vertex) for name, _, by_vertex, _ in liquid["parts"]], [("dyed", True)])
        for color in liquid["COLOR_0"]:
            for c, coffee, milk in zip(color, (0.05, 0.03, 0.01), (0.95, 0.93, 0.88)):
                self.assertAlmostEqual(c, 0.1 * linear(coffee) + 0.9 * linear(milk), places=4)
        # The mixture stands in the files of the surface, and nothing of it where a scene has no species.
        self.assertIn(b"property float w_milk\n", Path(self.frame("liquid_00001.ply")).read_bytes())
        self.assertNotIn(b"w_milk", Path(self.frame("solid_00001.ply")).read_bytes())
        self.assertTrue(all(abs(row[10] - 0.9) < 1e-5 for row in read_mesh(self.frame("liquid_00001.ply")).vertices))
        self.assertTrue(all(abs(row[0] - 0.9) < 1e-5 for row in liquid["_W_MILK"]))

    def test_a_camera_inside_a_solid_is_said_once(self):
        inside = ["--set", "output.camera.eye=[0.8, 1, 0.8]", "--set", "output.camera.look_at=[0.8, 0, 0.8]"]
        text = "the camera stands inside a solid"
        for options in ([], ["--no-still", "--export", "png"], ["--no-still", "--export", "pov"], ["--export", "png"]):
            said = self.run_scene("--frames", "1", *inside, *options, "--overwrite")
            self.assertEqual(said.stderr.count(text), 1, options)
            warnings = json.loads(Path(self.path("run", "run.json")).read_text())["warnings"]
            self.assertEqual(sum(text in warning for warning in warnings), 1)
        self.assertNotIn(text, self.run_scene("--frames", "0", *inside, "--no-still", "--overwrite").stderr)
        # Neither a run that is drawn nor a scene that is run for it says it twice.
        size = ["--renderer", "builtin", "--size", "16x16", "--samples", "1"]
        self.run_scene("--frames", "2", *inside, "--export", "surface", "--overwrite")
        for what in (["run"], [SCENE, "--backend", "cpu", "--time", "0.04", *inside]):
            said = self.meltsim("render", *what, *size)
            self.assertEqual(said.stderr.count(text), 1, said.stderr)

    def test_a_full_disk_leaves_no_half_frames(self):
        def small_files():  # as a full disk does, a limit makes writing fail in the middle of a file
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (60000, 60000))

        failed = self.run_scene("--export", "ply,surface", code=5, preexec_fn=small_files)
        said = re.match(r"run/frames/(liquid_\d+\.ply): cannot be written: \w", failed.stderr)
        self.assertTrue(said, failed.stderr)
        self.assertTrue(os.path.exists(self.frame("particles_00000.ply")))
        left = os.listdir(self.path("run", "frames"))
        self.assertFalse([name for name in left if name.startswith(said[1]) or name.endswith(".tmp")])
        for name in left:
            if not name.startswith("particles"):
                read_mesh(self.frame(name))  # whole


VTK = """
import json, sys
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOGeometry import vtkOBJReader
found = {}
for path in sys.argv[1:]:
    reader = {"vtp": vtkXMLPolyDataReader, "ply": vtkPLYReader, "obj": vtkOBJReader}[path[-3:]]()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    arrays = data.GetPointData()
    found[path.split("/")[-1]] = {
        "points": data.GetNumberOfPoints(), "polys": data.GetNumberOfPolys(), "bounds": data.GetBounds(),
        "arrays": {arrays.GetArrayName(i): arrays.GetArray(i).GetRange() for i in range(arrays.GetNumberOfArrays())}}
print(json.dumps(found))
"""


def python_with_vtk():
    for python in (sys.executable, "/usr/bin/python3"):
        if shutil.which(python) and subprocess.run([python, "-c", "import vtkmodules.vtkIOXML"],
                                                   capture_output=True).returncode == 0:
            return python
    return None


# Names of directories that gnuplot, POV-Ray or ffmpeg would take for commands, pipes, options, lists or protocols.
ODD_NAMES = ("<touch hit;#", "|touch hit;#", "-version", "+Ihit", "pipe:1", "concat:a|b", "@hit", "a'b\"c$(touch hit)`touch hit`",
             "per %d cent", "\\n'; system 'touch hit")


class OddNames:
    """What runs another program on a run's directory runs it on the files of that directory, whatever its name."""

    def check_odd_names(self, command, made):
        self.run_scene("--frames", "1", "--export", "surface", "--set", "output.picture.samples=1")
        for name in ODD_NAMES:
            with self.subTest(name=name):
                os.rename(self.path("run"), self.path(name))
                self.meltsim(command, *(["--renderer", self.renderer] if command == "render" else []), "--", name)
                for file in made:
                    self.assertGreater(os.path.getsize(self.path(name, file)), 500)
                    os.remove(self.path(name, file))
                os.rename(self.path(name), self.path("run"))
                left = [at for at, _, names in os.walk(self.directory.name) for n in names if "hit" in n]
                self.assertEqual(left, [])


class Vtk(Pictures):
    def read(self, *names):
        done = subprocess.run([python_with_vtk(), "-c", VTK, *(self.frame(name) for name in names)],
                              capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)

    def test_vtk_reads_particles_and_surfaces(self):
        self.run_scene("--frames", "1", "--export", "vtp,surface,obj")
        found = self.read("particles_00000.vtp", "liquid_00000.ply", "solid_00000.obj")
        self.assertEqual(found["particles_00000.vtp"]["points"], 192 + 32)
        self.assertEqual(found["particles_00000.vtp"]["arrays"]["temperature"], [-10, 40])
        self.assertEqual(found["particles_00000.vtp"]["arrays"]["phase"], [0, 1])
        liquid, solid = read_mesh(self.frame("liquid_00000.ply")), read_mesh(self.frame("solid_00000.ply"))
        self.assertEqual([found["liquid_00000.ply"][key] for key in ("points", "polys")],
                         [len(liquid.vertices), len(liquid.faces)])
        self.assertEqual(found["solid_00000.obj"]["polys"], len(solid.faces))

    def test_vtk_reads_what_is_empty(self):
        self.run_scene("--frames", "0", *DRY, "--set", "bodies=[]", "--export", "vtp,surface,obj")
        found = self.read("particles_00000.vtp", "liquid_00000.ply", "solid_00000.obj")
        self.assertEqual(found["particles_00000.vtp"]["points"], 1)
        self.assertEqual((found["liquid_00000.ply"]["polys"], found["solid_00000.obj"]["polys"]), (1, 1))


class Povray(OddNames, Pictures):
    renderer = "povray"

    def test_names_of_directories_are_names_only(self):
        self.check_odd_names("render", ["pictures/natural_00000.png", "natural_sheet.png"])

    def test_povray_draws_every_kind_of_frame(self):
        for options in (["--frames", "0"], MELT, DRY + ["--frames", "0"],
                        DRY + ["--frames", "0", "--set", "bodies=[]"],
                        ["--frames", "0", "--set", "output.picture.look=temperature"]):
            self.run_scene(*options, "--export", "pov", "--overwrite")
            last = json.loads(Path(self.path("run", "run.json")).read_text())["final"]["frames"] - 1
            done = subprocess.run(["povray", f"+I{self.frame(f'scene_{last:05}.pov')}", "+O" + self.path("pov.png"),
                                   "+W64", "+H36", "-D"], capture_output=True, text=True, timeout=300)
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            shown = colors(self.path("pov.png"))
            self.assertGreater(len(shown), 20)
            if "output.picture.look=temperature" in options:
                self.assertGreater(sum(n for (r, _, b), n in shown.items() if b > r + 50), 10)

    def test_render_takes_povray(self):
        self.run_scene("--frames", "0", "--export", "surface")
        said = self.meltsim("render", "run")
        self.assertIn("renderer: /", said.stdout)
        self.assertEqual(sorted(os.listdir(self.path("run", "pictures"))), [".lock", "natural_00000.png"])
        self.assertGreater(len(colors(self.path("run", "pictures", "natural_00000.png"))), 50)


class Movie(OddNames, Pictures):
    renderer = "builtin"

    def test_names_of_directories_are_names_only(self):
        self.check_odd_names("render", ["natural.mp4"])

    def test_the_movie_lasts_as_long_as_the_run(self):
        self.run_scene("--export", "ply")
        self.meltsim("render", "run", "--renderer", "builtin")
        said = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "format=duration:stream=width,height", "-of",
                               "json", self.path("run", "natural.mp4")], capture_output=True, text=True, check=True)
        found = json.loads(said.stdout)
        self.assertEqual((found["streams"][0]["width"], found["streams"][0]["height"]), (64, 36))
        # 0.2 s of the run, and the last picture stays for a second.
        self.assertAlmostEqual(float(found["format"]["duration"]), 1.2, delta=0.09)
        self.assertEqual([name for name in os.listdir(self.path("run")) if "ffmpeg" in name or "ffconcat" in name], [])


class Plot(OddNames, Pictures):
    def test_names_of_directories_are_names_only(self):
        self.check_odd_names("plot", ["plots.svg", "plots.png"])

    def test_plots_are_drawn(self):
        self.run_scene()
        self.meltsim("plot", "run")
        svg = Path(self.path("run", "plots.svg")).read_text()
        for title in ("melted", "temperature", "largest speed", "time per step", "tiny"):
            self.assertIn(title, svg)
        shown = colors(self.path("run", "plots.png"))
        for ink in ((0xd1, 0x39, 0x2b), (0x2f, 0x62, 0xc4), (0x1f, 0x8a, 0x8a)):  # max, min, speed
            self.assertGreater(sum(n for pixel, n in shown.items() if max(abs(a - b) for a, b in zip(pixel, ink)) < 40), 50)

    def test_an_empty_scene_has_no_temperature(self):
        """A jet of 90 degrees that begins at 0.06 s: one horizontal line, not one that climbs from 0."""
        self.run_scene("--set", "fluids=[]", "--set", "bodies=[]", "--set", "emitters[0].from=0.06", "--frames", "5")
        self.meltsim("plot", "run")
        _, _, rows = read_png(self.path("run", "plots.png"))
        blue = [y for y, row in enumerate(rows[:400]) if any(p[2] > p[0] + 60 and p[2] > p[1] + 60 for p in row[500:1000])]
        self.assertLess(len(blue), 12)  # the line, and its sample in the legend; the plot is some 300 pixels high

    def test_a_scene_that_stays_empty_has_plots_too(self):
        self.run_scene("--set", "fluids=[]", "--set", "bodies=[]", "--set", "emitters=[]", "--frames", "3")
        self.meltsim("plot", "run")

    def test_a_run_of_one_row_has_plots_too(self):
        self.run_scene("--frames", "0")
        self.meltsim("plot", "run")


NEEDS = {"own": (Own, True, ""), "vtk": (Vtk, PART == "vtk" and python_with_vtk(), "python3-vtk9"),
         "povray": (Povray, shutil.which("povray"), "povray"),
         "movie": (Movie, shutil.which("ffmpeg") and shutil.which("ffprobe"), "ffmpeg"),
         "plot": (Plot, shutil.which("gnuplot"), "gnuplot-nox")}

if __name__ == "__main__":
    case, there, package = NEEDS[PART]
    if not there:
        print(f"SKIPPED: needs what is in the Debian package {package}")
        sys.exit(77)
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(case)
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful())
