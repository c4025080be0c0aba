# SPDX-License-Identifier: Apache-2.0
"""blender_import.py MELTSIM SCENE SCRIPT: what examples/blender/import_meltsim.py reads of a run, and, where there is Blender (the program, or
bpy from PyPI), what it makes of it. Ends with 77 without NumPy."""
import contextlib
import importlib.util
import io
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import types
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("SKIPPED: no NumPy here")
    sys.exit(77)
try:
    import bpy
except ImportError:
    bpy = None

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from png_reader import linear  # noqa: E402

arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
if bpy is None and shutil.which("blender"):  # the whole test runs in it
    sys.exit(subprocess.call(["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python", os.path.abspath(__file__),
                              "--", *map(os.path.abspath, arguments)]))
if bpy is None:
    sys.modules["bpy"] = types.ModuleType("bpy")

meltsim, scene, script = arguments[:3]
sys.argv = sys.argv[:1]
spec = importlib.util.spec_from_file_location("read_meltsim", script)
reader = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reader)
own = [getattr(bpy.app, "binary_path", ""), "--background", "--factory-startup"] if bpy else []
program = [*own, "--python", script, "--"] if own and own[0] else [sys.executable, script, "--"]


def run(out, *options, of=scene, frames=3, formats="surface"):
    subprocess.run([meltsim, "run", of, "--out", out, "--export", formats, "--frames", str(frames), "--threads", "1", "--no-page", "--no-still", "--quiet",
                    *options], check=True)
    return Path(out)


def refused(call, *parts):
    """Whether a call ends with an error that says all of this."""
    try:
        call()
    except reader.RunError as error:
        assert all(part in str(error) for part in parts), error
        return True
    return False


def is_skipped(without):
    if not without:
        print("SKIPPED: what Blender makes of it; no Blender here (pip install bpy)")
    return not without


def reads_velocities():
    # A field that is linear in space is met where particles are dense; far from all of them it is 0 and not NaN.
    rng = np.random.default_rng(1)
    drawn = np.zeros(20000, [("position", "<f4", 3), ("velocity", "<f4", 3)])
    drawn["position"] = rng.uniform(-1, 1, (20000, 3))
    drawn["velocity"] = drawn["position"] * (1, 2, -3) + (5, 0, 0)
    at = rng.uniform(-0.7, 0.7, (50, 3)).astype(np.float32)
    assert np.abs(reader.velocities(at, drawn, 0.15) - (at * (1, 2, -3) + (5, 0, 0))).max() < 0.15  # a cell, times the gradient, over 3
    assert (reader.velocities(np.array([(9, 9, 9)], np.float32), drawn, 0.15) == 0).all()


def reads_frames(folder):
    done = reader.Run(run(folder / "run", formats="surface,ply"))
    assert reader.surface_frames(done) == [0, 1, 2, 3] and reader.surface_frames(done, 2) == [0, 2]
    frames = [reader.read_frame(done, k) for k in range(4)]
    cold, hot = reader.temperatures(frames)
    particles = [reader.read_particles(done, k) for k in range(4)]
    assert cold < hot and all(p["temperature"].min() <= cold + 1e-3 or p["temperature"].max() >= hot - 1e-3 for p in particles)
    fell = 0
    for parts, p in zip(frames, particles):
        for name, (vertices, triangles, velocity) in parts.items():
            of_phase = p["velocity"][p["phase"] == ("liquid", "solid").index(name)].astype(float)
            assert velocity.shape == (len(vertices), 3) and triangles.max() < len(vertices)
            # Means of what is around: never beyond it.
            assert (velocity >= of_phase.min(0) - 1e-6).all() and (velocity <= of_phase.max(0) + 1e-6).all()
            fell += float(np.abs(velocity).max() > 0.1)
    assert fell > 0, "nothing moved"
    Path(done.file("particles", 2)).unlink()
    assert all(velocity is None for _, _, velocity in reader.read_frame(done, 2).values())
    return frames, (cold, hot)


def reads_mixtures(folder):
    # Frames of scenes with species have columns more.
    salt = "materials.salt={density: 2165, dissolves_in: water, diffusivity_in: 1.6e-9, color: [1, 0, 0]}"
    salty = reader.Run(run(folder / "salty", "--set", salt, "--set", "fluids[0].fractions={salt: 0.25}", formats="surface,ply", frames=1))
    rows = reader.read_particles(salty, 1)
    liquid = rows[rows["phase"] == 0]
    assert set(rows["phase"]) == {0, 1} and np.abs(rows["velocity"]).max() < 20 and np.abs(rows["position"]).max() < 3
    assert (np.sort(rows["id"]) == np.unique(rows["id"])).all() and abs(np.median(liquid["w_salt"]) - 0.25) < 1e-6
    parts = reader.read_frame(salty, 1)
    assert abs(np.median(parts["liquid"][0]["w_salt"]) - 0.25) < 1e-6 and "w_salt" not in parts["solid"][0].dtype.names
    for vertices, triangles, velocity in parts.values():
        assert triangles.max() < len(vertices) and np.abs(velocity).max() < 20 and np.isfinite(velocity).all()
    # A clear solvent has the colour of a species; with one of its own, they mix. What dissolves up to a limit shows nothing.
    vertices, triangles = parts["liquid"][:2]
    color, share = reader.dyes(salty, vertices, triangles)
    much = vertices["w_salt"] > 0.24
    assert abs(np.median(share) - 1) < 1e-6 and np.allclose(np.median(color[much], 0), (1, 0, 0), atol=1e-6)
    salty.liquid_colors[0] = np.array([0.0, 1, 0])
    assert np.allclose(np.median(reader.dyes(salty, vertices, triangles)[0], 0), (0.25, 0.75, 0), atol=1e-3)
    limited = reader.Run(run(folder / "limited", "--set", salt.replace("color", "solubility: 0.3, color"), frames=0))
    assert limited.species_colors == [None]


def leaves_out_other_runs(folder):
    out = folder / "again"
    run(out, formats="surface,ply")
    assert reader.read_frame(reader.Run(out), 1)["liquid"].velocity is not None
    run(out, "--overwrite", "--set", "solver.gravity=[0,-1,0]", frames=1)
    done = reader.Run(out)
    assert (out / "frames" / "particles_00001.ply").exists() and (out / "frames" / "liquid_00003.ply").exists()
    assert all(part.velocity is None for part in reader.read_frame(done, 1).values()), "velocities of the first run"
    assert reader.surface_frames(done) == [0, 1], "frames of the first run"
    with contextlib.redirect_stdout(io.StringIO()) as said:
        reader.tell(done, [0, 1], 1)
    assert "wrote 2 frames; 2 of an earlier, longer run" in said.getvalue()
    # Of a run that goes on or was killed the rows of stats.csv count, but for the last, whose files may not be whole.
    told = json.loads((out / "run.json").read_text())
    del told["final"]
    (out / "run.json").write_text(json.dumps(told))
    assert reader.surface_frames(reader.Run(out)) == [0] and not reader.Run(out).ended


def upright_of(path):
    """The rotation of the node that turns a .glb file's scene, as a matrix."""
    data = path.read_bytes()
    nodes = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])["nodes"]
    x, y, z, w = next((node["rotation"] for node in nodes if node["name"] == "upright"), (0, 0, 0, 1))
    q = np.array([x, y, z])
    return np.array([2 * v @ q * q + (w * w - q @ q) * v + 2 * w * np.cross(q, v) for v in np.eye(3)]).T


def turns_as_glb(folder):
    for number, gravity in enumerate(([0, -9.81, 0], [2, -9.6, 0], [0, 0, -9.81], [0, 9.81, 0], [3, 4, -5], [0, 0, 0])):
        done = reader.Run(run(folder / f"up{number}", "--set", f"solver.gravity={gravity}", formats="glb", frames=0))
        turn = reader.turn_of(done, "auto")
        assert np.allclose(turn, reader.BLENDER_UP @ upright_of(Path(done.directory) / "frames" / "surface_00000.glb"), atol=1e-9), gravity
        assert np.allclose(turn @ gravity, (0, 0, -np.linalg.norm(gravity)), atol=1e-9) and np.isclose(np.linalg.det(turn), 1)
    axes = {axis: reader.turn_of(done, axis) @ np.eye(3) for axis in "xyz"}
    assert all(np.allclose(axes[axis][:, k], (0, 0, 1)) for k, axis in enumerate("xyz")) and np.allclose(axes["z"], np.eye(3))
    assert np.allclose(axes["y"] @ (1, 2, 3), (1, -3, 2))
    assert refused(lambda: reader.turn_of(done, "w"), "up: w", "auto")


def names_what_is_wrong(folder):
    glb, done = folder / "up0", folder / "run"
    assert refused(lambda: reader.import_frame(glb, 0), str(glb), "wrote no surfaces (output.export: glb)", "--export surface, or import its .glb")
    assert refused(lambda: reader.import_sequence(glb), "wrote no surfaces")
    assert refused(lambda: reader.import_frame(folder / "nowhere", 0), "nowhere: there is no such directory", "name the one")
    assert refused(lambda: reader.import_frame(done / "frames", 0), "holds no run.json", "name the directory of a run")
    assert refused(lambda: reader.import_frame(done, 99), "frame 99", "wrote frames 0 to 3", "choose one")
    assert refused(lambda: reader.import_sequence(done, every=0), "every: 0")
    half = folder / "half.ply"
    half.write_bytes((done / "frames" / "liquid_00000.ply").read_bytes()[:-100])
    assert refused(lambda: reader.read(half), "half.ply: is not a whole PLY file")
    half.write_bytes(b"")
    assert refused(lambda: reader.read(half), "half.ply: is not a whole PLY file")
    (folder / "run.json").write_text("{}")
    assert refused(lambda: reader.Run(folder), "is not a whole run.json")
    assert refused(lambda: reader.options_of([str(done), "--range", "9", "1"]), "--range: 9 is not below 1")
    assert refused(lambda: reader.options_of([str(done), "--every", "2"]), "--every 2", "add --sequence")
    assert refused(lambda: reader.options_of([str(done), "--up", "w"]), "--up", "'auto', 'x', 'y', 'z'")
    assert refused(lambda: reader.options_of([str(done), "--save", str(folder / "no" / "a.blend")]), "no: there is no such directory")
    # Nobody's open Blender is closed; one in the background ends with 1.
    before = reader.bpy
    for background in (False, True):
        reader.bpy = types.SimpleNamespace(app=types.SimpleNamespace(background=background))
        for wrong in (["nowhere"], [str(glb)], ["--frame", "x"], ["--help"]):
            with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()):
                try:
                    reader.run_as_program(wrong)
                    code = None
                except SystemExit as end:
                    code = end.code
            assert code == ((0 if wrong == ["--help"] else 1) if background else None), (wrong, background, code)
            assert wrong == ["--help"] or said.getvalue().startswith("error: ") and "Traceback" not in said.getvalue(), said.getvalue()
    reader.bpy = before


# ---- In Blender

def values_of(mesh, name, count, key):
    values = np.empty(count * len(mesh.vertices), np.float32)
    mesh.attributes[name].data.foreach_get(key, values)
    return values.reshape(-1, count) if count > 1 else values


def makes_animations(done, frames, span):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = reader.import_sequence(str(done), span=span, look="temperature")
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (1, 4)
    for shown in range(1, 5):
        bpy.context.scene.frame_set(shown)
        seen = sorted(o.name for o in made if not o.hide_render)
        assert seen == sorted(f"{name}_{shown - 1:05}" for name in frames[shown - 1]), seen
    for o in made:
        kinds = {a.name for a in o.data.attributes}
        assert {"temperature", "material", "liquid_fraction", "warmth"} <= kinds and ("velocity" in kinds) == (not o.name.endswith("00002")), kinds
        # Its colour is that of its temperature on the one scale of all frames; y of the scene is Blender's z.
        seen = values_of(o.data, "warmth", 4, "color")
        assert np.allclose(seen, reader.colors(values_of(o.data, "temperature", 1, "value"), *span), atol=1e-4)
        assert (values_of(o.data, "celsius", 1, "value") == values_of(o.data, "temperature", 1, "value")).all()
        if "velocity" in kinds:
            name, number = o.name.split("_")
            x, y, z = frames[int(number)][name][2].T
            assert np.allclose(values_of(o.data, "velocity", 3, "vector"), np.stack([x, -z, y], 1), atol=1e-6)
    assert {m.name for m in bpy.data.materials} == {"meltsim liquid", "meltsim solid"}
    assert all(len(m.node_tree.nodes) == 3 for m in bpy.data.materials), "nodes pile up"
    made = reader.import_sequence(str(done), every=2)
    render = bpy.context.scene.render
    assert {o.name.split("_")[1][:5] for o in made} == {"00000", "00002"}  # of second objects of a name Blender appends a number
    assert bpy.context.scene.frame_end == 2 and abs(render.fps / render.fps_base - 12.5) < 1e-6


def socket(shader, *names):
    return next(shader.inputs[name] for name in names if name in shader.inputs)


def shows_colors(folder):
    text = Path(scene).read_text().replace("bodies: [", "bodies: [{name: lump, shape: {box: [[0.2, 1.4, 0.2], [0.6, 1.8, 0.6]]}, material: wax, fixed: true}, ")
    (folder / "wax.yaml").write_text(text.replace("materials:", "materials:\n  wax: {density: 900, color: [0.8, 0.5, 0.1]}"))
    done = run(folder / "wax", of=folder / "wax.yaml", frames=0)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    liquid, solid = reader.import_frame(str(done), 0)
    assert [m.name for m in liquid.data.materials] == ["meltsim water"]
    shader = liquid.data.materials[0].node_tree.nodes["Principled BSDF"]
    assert socket(shader, "Transmission Weight", "Transmission").default_value == 1 and abs(socket(shader, "IOR").default_value - 1.333) < 1e-6
    assert [m.name for m in solid.data.materials] == ["meltsim ice", "meltsim colored solid"]
    color, body = values_of(solid.data, "tint", 4, "color"), reader.read(reader.Run(done).file("solid", 0))[0]["body"]
    assert set(body) == {0, 1} and np.allclose(color[body == 0, :3], np.array([linear(c) for c in (0.8, 0.5, 0.1)]), atol=1e-4)
    for polygon in solid.data.polygons:
        assert polygon.material_index == (body[polygon.vertices[0]] == 0)
    dyed = run(folder / "dyed", "--set", "materials.water.color=[0.1, 0.2, 0.9]", "--set", "bodies[0].visible=false", frames=0)
    (liquid,) = reader.import_frame(str(dyed), 0)  # the scene hides its body
    assert [m.name for m in liquid.data.materials] == ["meltsim dyed liquid"]
    assert np.allclose(values_of(liquid.data, "tint", 4, "color")[:, :3], np.array([linear(c) for c in (0.1, 0.2, 0.9)]), atol=1e-4)
    assert (values_of(liquid.data, "clear", 1, "value") == 0).all()
    read = {n.attribute_name for m in bpy.data.materials for n in m.node_tree.nodes if n.type == "ATTRIBUTE"}
    assert read == {"clear", "tint"}, read  # Cycles reads 0 of what is called as an attribute of volumes is: color, temperature, velocity, density


def points_of(made):
    return np.array([made.matrix_world @ v.co for v in made.data.vertices])


def lies_on_its_glb(folder):
    done = run(folder / "tilted", "--set", "solver.gravity=[2, -9.6, 1]", formats="surface,glb", frames=1)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ours = {o.name.split("_")[0]: points_of(o) for o in reader.import_frame(str(done), 1)}
    if "bool" not in vars(np):
        np.bool = bool  # Debian's importer is older than its NumPy
    try:
        bpy.ops.import_scene.gltf(filepath=str(done / "frames" / "surface_00001.glb"))
    except (AttributeError, RuntimeError) as error:
        print(f"SKIPPED: overlay of formats; this Blender imports no .glb ({str(error).strip().splitlines()[-1]})")
        return
    bpy.context.view_layer.update()
    for name, points in ours.items():
        theirs = points_of(bpy.data.objects[name])
        assert np.allclose(points.min(0), theirs.min(0), atol=1e-4) and np.allclose(points.max(0), theirs.max(0), atol=1e-4), name


def call(*options, before=()):
    command = [*own, *before, "--python", script, "--"] if before else program
    return subprocess.run([*command, *map(str, options)], capture_output=True, text=True)


def saves_whole_scenes(folder):
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector
    for camera in ("{eye: [3, 2, 4], look_at: [0.8, 0.3, 0.8], fov: 30}", None):
        eye = ("--set", f"output.camera={camera}") if camera else ()
        done = run(folder / f"scene{len(eye)}", *eye, "--fps", "12.5", formats="surface")
        saved = folder / "saved.blend"
        ended = call(done, "--sequence", "--save", saved)
        assert ended.returncode == 0, ended.stderr
        bpy.ops.wm.open_mainfile(filepath=str(saved))
        shown = bpy.context.scene
        assert "Cube" not in bpy.data.objects and "Light" not in bpy.data.objects, list(bpy.data.objects)
        assert shown.world and any(o.type == "LIGHT" for o in shown.objects) and shown.camera and shown.render.engine == "CYCLES"
        assert (shown.render.resolution_x, shown.render.resolution_y) == (64, 36)
        assert abs(shown.render.fps / shown.render.fps_base - 12.5) < 1e-6 and (shown.frame_start, shown.frame_end) == (1, 4)
        bpy.context.view_layer.update()
        seen = lambda x: np.array(world_to_camera_view(shown, shown.camera, Vector(x)))  # 0 to 1 in the picture, and the distance
        if camera:
            assert np.allclose(shown.camera.matrix_world.translation, (3, -4, 2), atol=1e-5)
            assert np.allclose(seen((0.8, -0.8, 0.3))[:2], 0.5, atol=1e-5) and abs(np.degrees(shown.camera.data.angle_y) - 30) < 1e-3
            assert seen((0.8, -0.8, 0.5))[1] > 0.5 and seen((1.1, -0.5, 0.3))[0] > 0.5
        else:
            views = np.array([seen(x) for o in bpy.data.objects if o.name.startswith(("liquid", "solid")) for x in points_of(o)])
            assert views[:, :2].min() > 0 and views[:, :2].max() < 1 and views[:, 2].min() > shown.camera.data.clip_start
            assert np.ptp(views[:, :2], axis=0).max() > 0.4, "it is far away"
    if not own[0]:
        return print("SKIPPED: importing into a file that is open; bpy of PyPI opens none at its start")
    bpy.ops.wm.read_factory_settings()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "artist.blend"))
    assert call(done, "--save", saved, before=[folder / "artist.blend"]).returncode == 0
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    names = {o.name for o in bpy.data.objects}
    assert {"Cube", "Light", "Camera", "liquid_00000"} <= names and not any(name.startswith("meltsim") for name in names), names


def ends_with_codes(folder):
    for options, words in (((folder / "up0", "--sequence", "--save", folder / "a.blend"), "wrote no surfaces"),
                           ((folder / "nowhere",), "no such directory"), ((folder / "run", "--frame", 99), "frame 99"),
                           ((folder / "run", "--look", "odd"), "--look")):
        ended = call(*options)
        assert ended.returncode == 1 and "error: " in ended.stderr and words in ended.stderr and "Traceback" not in ended.stderr, ended
    assert not (folder / "a.blend").exists()


def runs_in_the_scripting_tab(folder):
    """As an artist does it: Text > Open, Run Script, and two lines in the Python Console."""
    bpy.ops.wm.read_factory_settings()
    windows = bpy.context.window_manager.windows
    if len(windows) == 0:
        return print("SKIPPED: the Scripting tab; there is none without the program Blender")
    text, area = bpy.data.texts.load(script), windows[0].screen.areas[0]
    area.type = "TEXT_EDITOR"
    area.spaces[0].text = text
    with bpy.context.temp_override(window=windows[0], area=area, region=area.regions[-1], edit_text=text, space_data=area.spaces[0]):
        assert bpy.ops.text.run_script() == {"FINISHED"}
    called = next(name for name in ("console_python", "_console_python") if importlib.util.find_spec(name))  # up to and from Blender 5.0
    console = importlib.import_module(called).get_console(1)[0]
    with contextlib.redirect_stderr(io.StringIO()) as said:
        console.push("from import_meltsim import import_frame, import_sequence")
        console.push(f"import_sequence({str(folder / 'run')!r})")
    assert "Error" not in said.getvalue(), said.getvalue()
    assert {"Cube", "liquid_00000", "liquid_00003"} <= {o.name for o in bpy.data.objects}


def main():
    reads_velocities()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        frames, span = reads_frames(folder)
        for check in (reads_mixtures, leaves_out_other_runs, turns_as_glb, names_what_is_wrong):
            check(folder)
        if not is_skipped(bpy):
            makes_animations(folder / "run", frames, span)
            for check in (shows_colors, lies_on_its_glb, saves_whole_scenes, ends_with_codes, runs_in_the_scripting_tab):
                check(folder)
    print("ok")


main()
