# SPDX-License-Identifier: Apache-2.0
"""Imports surfaces of a meltsim run (`--export surface`) into Blender 3.3 or later, with their temperature.

  blender --background --python import_meltsim.py -- RUN_DIRECTORY [--frame N] [--up y|z] [--save FILE.blend]

or in Blender's own Scripting tab: run it, then `import_frame("out/ice_block-001", 12)`. Temperatures come as the
vertex attribute "temperature" [degrees Celsius] and as the colour attribute "warmth" (blue, yellow, red), which the
materials "meltsim solid" and "meltsim liquid" show. Debian: apt install blender python3-numpy. Arrays are handed over whole (foreach_set), so a surface of
160,000 triangles takes a fraction of a second.
"""
import argparse
import os
import sys

import bpy
import numpy

RAMP = numpy.array([(0.14, 0.25, 0.62), (0.27, 0.55, 0.85), (0.68, 0.86, 0.91), (0.99, 0.90, 0.45), (0.96, 0.52, 0.22),
                    (0.75, 0.09, 0.12)])
VERTEX = numpy.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("temperature", "<f4"), ("body", "<i4"),
                      ("material", "<i4")])
FACE = numpy.dtype([("count", "u1"), ("vertices", "<u4", 3)])


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in data[:end].splitlines() if line.startswith(b"element")]
    # Files of earlier versions end with the body.
    kind = VERTEX if b"property int material" in data[:end] else numpy.dtype(VERTEX.descr[:-1])
    vertices = numpy.frombuffer(data, kind, counts[0], end)
    faces = numpy.frombuffer(data, FACE, counts[1], end + counts[0] * kind.itemsize)
    return vertices, faces["vertices"], b"comment placeholder" in data[:end]


def colors(temperature, cold, hot):
    x = numpy.clip((temperature - cold) / max(hot - cold, 1e-9), 0, 1) * (len(RAMP) - 1)
    shown = numpy.stack([numpy.interp(x, range(len(RAMP)), RAMP[:, k]) for k in range(3)] + [numpy.ones_like(x)], 1)
    shown[:, :3] **= 2.2  # Blender's colours are linear light
    return shown


def material(name, alpha):
    made = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes.get("Principled BSDF")
    source = nodes.new("ShaderNodeAttribute")
    source.attribute_name = "warmth"
    links.new(source.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Alpha"].default_value = alpha
    shader.inputs["Roughness"].default_value = 0.15
    return made


def add(name, vertices, triangles, cold, hot, alpha, up):
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
    warmth = mesh.attributes.new("warmth", "FLOAT_COLOR", "POINT")
    warmth.data.foreach_set("color", colors(temperature, cold, hot).astype(numpy.float32).ravel())
    mesh.update(calc_edges=True)
    mesh.validate()
    mesh.materials.append(material("meltsim " + name.split("_")[0], alpha))
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def import_frame(directory, frame, up="y"):
    """Objects of the liquid and of the solids of one frame; surfaces that hold nothing are left out. `up` is the scene's
    axis that becomes Blender's z."""
    read_parts = {}
    for name in ("liquid", "solid"):
        vertices, triangles, placeholder = read(os.path.join(directory, "frames", f"{name}_{frame:05}.ply"))
        if not placeholder:
            read_parts[name] = (vertices, triangles)
    every = numpy.concatenate([vertices["temperature"] for vertices, _ in read_parts.values()] or [numpy.zeros(1)])
    return [add(f"{name}_{frame:05}", *part, every.min(), every.max(), 0.5 if name == "liquid" else 1.0, up)
            for name, part in read_parts.items()]


if __name__ == "__main__" and "--" in sys.argv:
    parser = argparse.ArgumentParser()
    parser.add_argument("directory")
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--up", choices=("y", "z"), default="y")
    parser.add_argument("--save")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    for made in import_frame(options.directory, options.frame, options.up):
        values = numpy.empty(len(made.data.vertices), numpy.float32)
        made.data.attributes["temperature"].data.foreach_get("value", values)
        print(f"{made.name}: {len(made.data.vertices)} vertices, {len(made.data.polygons)} triangles, "
              f"{values.min():.2f} to {values.max():.2f} degrees Celsius")
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))
