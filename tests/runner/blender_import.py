# SPDX-License-Identifier: Apache-2.0
"""blender_import.py MELTSIM SCENE SCRIPT: what examples/blender/import_meltsim.py reads of a run, and, where Blender is installed as a module
(bpy from PyPI), what it makes of it. Ends with 77 without NumPy."""
import importlib.util
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
    sys.modules["bpy"] = types.ModuleType("bpy")

meltsim, scene, script = sys.argv[1:4]
sys.argv = sys.argv[:1]
spec = importlib.util.spec_from_file_location("import_meltsim", script)
reader = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reader)

# A field that is linear in space is met where particles are dense; far from all of them it is 0 and not NaN.
rng = np.random.default_rng(1)
drawn = np.zeros(20000, [("position", "<f4", 3), ("velocity", "<f4", 3)])
drawn["position"] = rng.uniform(-1, 1, (20000, 3))
drawn["velocity"] = drawn["position"] * (1, 2, -3) + (5, 0, 0)
at = rng.uniform(-0.7, 0.7, (50, 3)).astype(np.float32)
assert np.abs(reader.velocities(at, drawn, 0.15) - (at * (1, 2, -3) + (5, 0, 0))).max() < 0.15  # a cell, times the gradient, over 3
assert (reader.velocities(np.array([(9, 9, 9)], np.float32), drawn, 0.15) == 0).all()

with tempfile.TemporaryDirectory() as folder:
    run = Path(folder) / "run"
    subprocess.run([meltsim, "run", scene, "--out", run, "--export", "surface,ply", "--frames", "3", "--no-page", "--quiet"], check=True)
    assert reader.frames_of(run) == [0, 1, 2, 3]
    frames = [reader.read_frame(run, k) for k in range(4)]
    cold, hot = reader.temperatures(frames)
    particles = [reader.read_particles(run / "frames" / f"particles_{k:05}.ply") for k in range(4)]
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
    (run / "frames" / "particles_00002.ply").unlink()
    assert all(velocity is None for _, _, velocity in reader.read_frame(run, 2).values())
    # Frames of scenes with species have columns more.
    salty = Path(folder) / "salty"
    salt = "materials.salt={density: 2165, dissolves_in: water, diffusivity_in: 1.6e-9}"
    subprocess.run([meltsim, "run", scene, "--out", salty, "--export", "surface,ply", "--frames", "1", "--no-page", "--quiet", "--set", salt,
                    "--set", "fluids[0].fractions={salt: 0.25}"], check=True)
    rows = reader.read_particles(salty / "frames" / "particles_00001.ply")
    liquid = rows[rows["phase"] == 0]
    assert set(rows["phase"]) == {0, 1} and np.abs(rows["velocity"]).max() < 20 and np.abs(rows["position"]).max() < 3
    assert (np.sort(rows["id"]) == np.unique(rows["id"])).all() and abs(np.median(liquid["w_salt"]) - 0.25) < 1e-6
    parts = reader.read_frame(salty, 1)
    assert abs(np.median(parts["liquid"][0]["w_salt"]) - 0.25) < 1e-6 and "w_salt" not in parts["solid"][0].dtype.names
    for vertices, triangles, velocity in parts.values():
        assert triangles.max() < len(vertices) and np.abs(velocity).max() < 20 and np.isfinite(velocity).all()
    if bpy is None:
        print("ok, but for what Blender makes of it: pip install bpy")
        sys.exit(0)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = reader.import_sequence(str(run), span=(cold, hot))
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (1, 4)
    for shown in range(1, 5):
        bpy.context.scene.frame_set(shown)
        seen = sorted(o.name for o in made if not o.hide_render)
        assert seen == sorted(f"{name}_{shown - 1:05}" for name in frames[shown - 1]), seen
    for o in made:
        kinds = {a.name for a in o.data.attributes}
        assert {"temperature", "material", "liquid_fraction", "warmth"} <= kinds and ("velocity" in kinds) == (not o.name.endswith("00002")), kinds
        # Its colour is that of its temperature on the one scale of all frames; y of the scene is Blender's z.
        values, seen = np.empty(len(o.data.vertices), np.float32), np.empty(4 * len(o.data.vertices), np.float32)
        o.data.attributes["temperature"].data.foreach_get("value", values)
        o.data.attributes["warmth"].data.foreach_get("color", seen)
        assert np.allclose(seen.reshape(-1, 4), reader.colors(values, cold, hot), atol=1e-4)
        if "velocity" in kinds:
            name, number = o.name.split("_")
            x, y, z = frames[int(number)][name][2].T
            turned = np.empty(3 * len(o.data.vertices), np.float32)
            o.data.attributes["velocity"].data.foreach_get("vector", turned)
            assert np.allclose(turned.reshape(-1, 3), np.stack([x, -z, y], 1), atol=1e-6)
    assert all(len(m.node_tree.nodes) == 3 for m in bpy.data.materials), "nodes pile up"
print("ok")
