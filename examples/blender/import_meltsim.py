# SPDX-License-Identifier: Apache-2.0
"""Imports surfaces of a meltsim run (`--export surface`, with velocities `--export surface,ply`) into Blender 3.3 or later: one frame, or
all of them as an animation, with their temperature.

  blender --background --python import_meltsim.py -- RUN_DIRECTORY [--frame N | --sequence] [--range COLD HOT] [--up y|z] [--save FILE.blend]

or in Blender's own Scripting tab: run it, then `import_frame("out/ice_block-001", 12)` or `import_sequence("out/ice_block-001")`. Temperatures come as
the vertex attribute "temperature" [degrees Celsius] and as the colour attribute "warmth" (blue, yellow, red), which the
materials "meltsim solid" and "meltsim liquid" show; the ends of the colours are the same in all frames of a sequence. Where the run wrote particles, too,
the vertex attribute "velocity" [m/s] is that of the particles around, for motion blur. The vertex attribute "liquid_fraction" is 0 where all is solid and 1 where
all is liquid. What is dissolved in liquid has a vertex attribute each, "w_" and its name: its mass fraction. In a sequence every frame is an object that is shown in its frame
alone. Debian: apt install blender python3-numpy. Arrays are handed over whole (foreach_set), so a surface of
160,000 triangles takes a fraction of a second.
"""
import argparse
import json
import os
import re
import sys

import bpy
import numpy

RAMP = numpy.array([(0.14, 0.25, 0.62), (0.27, 0.55, 0.85), (0.68, 0.86, 0.91), (0.99, 0.90, 0.45), (0.96, 0.52, 0.22),
                    (0.75, 0.09, 0.12)])
TYPES = {"float": "<f4", "int": "<i4", "uint": "<u4", "uchar": "u1"}
VECTORS = {"x": "position", "vx": "velocity", "nx": "normal"}  # what three columns are called together, by the first
FACE = numpy.dtype([("count", "u1"), ("vertices", "<u4", 3)])


def read_rows(path):
    """The rows of vertices of a PLY file by the columns that its header names, its header, and what follows the rows."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    columns = [line.split()[1:] for line in header.splitlines() if line.startswith("property") and "list" not in line]
    kind = numpy.dtype([(VECTORS[name], TYPES[of], 3) if name in VECTORS else (name, TYPES[of])
                        for of, name in columns if name[-1] not in "yz" or name[:-1] not in ("", "v", "n")])
    count = int(re.search(r"element vertex (\d+)", header)[1])
    return numpy.frombuffer(data, kind, count, end), header, data[end + count * kind.itemsize:]


def read(path):
    """(vertices, triangles, whether the file holds a placeholder) of a surface."""
    vertices, header, rest = read_rows(path)
    faces = numpy.frombuffer(rest, FACE, int(re.search(r"element face (\d+)", header)[1]))
    return vertices, faces["vertices"], "comment placeholder" in header


def read_particles(path):
    """Particles of a frame (`--export ply`), or None where the run has not written them."""
    return read_rows(path)[0] if os.path.exists(path) else None


def velocities(at, particles, cell):
    """The velocity around each of `at`: of the particles nearest to it, by weights that fall off linearly over a cell."""
    low = numpy.minimum(particles["position"].min(0), at.min(0)) - 2 * cell
    size = ((numpy.maximum(particles["position"].max(0), at.max(0)) - low) / cell).astype(int) + 3
    corners = numpy.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])

    def around(x):
        place = (x - low) / cell
        whole = numpy.floor(place).astype(int)
        nodes = whole[:, None] + corners
        weights = numpy.where(corners == 1, (place - whole)[:, None], 1 - (place - whole)[:, None]).prod(2)
        return (nodes[..., 0] * size[1] + nodes[..., 1]) * size[2] + nodes[..., 2], weights

    nodes, weights = around(particles["position"])
    used, place = numpy.unique(nodes, return_inverse=True)  # a scene is mostly air
    place = place.reshape(nodes.shape)
    sums = numpy.stack([numpy.bincount(place.ravel(), (weights * v[:, None]).ravel(), len(used))
                        for v in (numpy.ones(len(particles)), *particles["velocity"].astype(float).T)], 1)
    nodes, weights = around(at)
    found = numpy.minimum(numpy.searchsorted(used, nodes), len(used) - 1)
    weights = weights * (used[found] == nodes)
    total = (weights[..., None] * sums[found]).sum(1)
    return total[:, 1:] / numpy.maximum(total[:, :1], 1e-30)


def colors(temperature, cold, hot):
    x = numpy.clip((temperature - cold) / max(hot - cold, 1e-9), 0, 1) * (len(RAMP) - 1)
    shown = numpy.stack([numpy.interp(x, range(len(RAMP)), RAMP[:, k]) for k in range(3)] + [numpy.ones_like(x)], 1)
    shown[:, :3] **= 2.2  # Blender's colours are linear light
    return shown


def material(name, alpha):
    made = bpy.data.materials.get(name)
    if made:
        return made
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes.get("Principled BSDF")
    source = nodes.new("ShaderNodeAttribute")
    source.attribute_name = "warmth"
    links.new(source.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Alpha"].default_value = alpha
    shader.inputs["Roughness"].default_value = 0.15
    return made


def add(name, vertices, triangles, velocity, cold, hot, alpha, up):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    x, y, z = vertices["position"].T
    mesh.vertices.foreach_set("co", numpy.stack([x, -z, y] if up == "y" else [x, y, z], 1).ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.astype(numpy.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("loop_total", numpy.full(len(triangles), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(len(triangles), dtype=bool))
    temperature = numpy.ascontiguousarray(vertices["temperature"])
    mesh.attributes.new("temperature", "FLOAT", "POINT").data.foreach_set("value", temperature)
    if "material" in vertices.dtype.names:
        numbers = numpy.ascontiguousarray(vertices["material"])
        mesh.attributes.new("material", "INT", "POINT").data.foreach_set("value", numbers)
    for column in (c for c in vertices.dtype.names if c == "liquid_fraction" or c.startswith("w_")):
        mesh.attributes.new(column, "FLOAT", "POINT").data.foreach_set("value", numpy.ascontiguousarray(vertices[column]))
    if velocity is not None:
        u, v, w = velocity.T
        turned = numpy.stack([u, -w, v] if up == "y" else [u, v, w], 1).astype(numpy.float32)
        mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turned.ravel())
    warmth = mesh.attributes.new("warmth", "FLOAT_COLOR", "POINT")
    warmth.data.foreach_set("color", colors(temperature, cold, hot).astype(numpy.float32).ravel())
    mesh.update(calc_edges=True)
    mesh.validate()
    mesh.materials.append(material("meltsim " + name.split("_")[0], alpha))
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def read_frame(directory, frame):
    """{"liquid": (vertices, triangles, velocities or None), "solid": ...} of a frame, without surfaces that hold nothing."""
    with open(os.path.join(directory, "run.json"), encoding="utf-8") as file:
        spacing = json.load(file)["scene"]["particles"]["spacing"]
    particles = read_particles(os.path.join(directory, "frames", f"particles_{frame:05}.ply"))
    parts = {}
    for phase, name in enumerate(("liquid", "solid")):
        vertices, triangles, placeholder = read(os.path.join(directory, "frames", f"{name}_{frame:05}.ply"))
        if placeholder:
            continue
        of_phase = None if particles is None else particles[particles["phase"] == phase]
        known = of_phase is not None and len(of_phase) > 0
        parts[name] = (vertices, triangles, velocities(vertices["position"], of_phase, 1.5 * spacing) if known else None)
    return parts


def temperatures(frames):
    """Coldest and hottest of the surfaces of some frames."""
    every = [vertices["temperature"] for parts in frames for vertices, _, _ in parts.values()] or [numpy.zeros(1)]
    return min(float(t.min()) for t in every), max(float(t.max()) for t in every)


def import_frame(directory, frame, up="y", span=None):
    """Objects of the liquid and of the solids of one frame; surfaces that hold nothing are left out. `up` is the scene's
    axis that becomes Blender's z; `span` the temperatures at the ends of the colours, those of the frame by default."""
    parts = read_frame(directory, frame)
    cold, hot = span or temperatures([parts])
    return [add(f"{name}_{frame:05}", *part, cold, hot, 0.5 if name == "liquid" else 1.0, up) for name, part in parts.items()]


def frames_of(directory):
    """Numbers of the frames that a run has written."""
    names = os.listdir(os.path.join(directory, "frames"))
    return sorted(int(found[1]) for found in (re.fullmatch(r"liquid_(\d+)\.ply", name) for name in names) if found)


def import_sequence(directory, up="y", span=None):
    """All frames of a run as an animation, which begins at Blender's frame 1 and goes as fast as the run was written."""
    frames = frames_of(directory)
    span = span or temperatures([read_frame(directory, frame) for frame in frames])
    made = []
    for shown, frame in enumerate(frames, start=1):
        for new in import_frame(directory, frame, up, span):
            for when, hidden in ((shown - 1, True), (shown, False), (shown + 1, True)):
                new.hide_render = new.hide_viewport = hidden
                new.keyframe_insert("hide_render", frame=when)
                new.keyframe_insert("hide_viewport", frame=when)
            made.append(new)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, max(1, len(frames))
    with open(os.path.join(directory, "run.json"), encoding="utf-8") as file:
        fps = json.load(file)["scene"]["time"]["fps"]
    scene.render.fps = max(1, round(fps))
    scene.render.fps_base = scene.render.fps / fps
    return made


if __name__ == "__main__" and "--" in sys.argv:
    parser = argparse.ArgumentParser()
    parser.add_argument("directory")
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--sequence", action="store_true")
    parser.add_argument("--range", type=float, nargs=2, metavar=("COLD", "HOT"))
    parser.add_argument("--up", choices=("y", "z"), default="y")
    parser.add_argument("--save")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    span = tuple(options.range) if options.range else None
    imported = (import_sequence(options.directory, options.up, span) if options.sequence else
                import_frame(options.directory, options.frame, options.up, span))
    for made in imported:
        values = numpy.empty(len(made.data.vertices), numpy.float32)
        made.data.attributes["temperature"].data.foreach_get("value", values)
        print(f"{made.name}: {len(made.data.vertices)} vertices, {len(made.data.polygons)} triangles, "
              f"{values.min():.2f} to {values.max():.2f} degrees Celsius")
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))
