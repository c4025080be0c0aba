# SPDX-License-Identifier: Apache-2.0
"""Imports surfaces of a meltsim run (`--export surface`, with velocities `--export surface,ply`) into Blender 3.3 or later: one frame, or
all of them as an animation, with their temperature.

  blender --background --python import_meltsim.py -- RUN_DIRECTORY [--frame N | --sequence [--every N]] [--look natural|temperature]
    [--range COLD HOT] [--up auto|x|y|z] [--save FILE.blend]

or in Blender's own Scripting tab: Text > Open this file, Run Script, and then in the Python Console of that tab

  from import_meltsim import import_frame, import_sequence
  import_sequence("/home/me/out/ice_block-001")

Only what run.json says that this run wrote is read, since an earlier, longer run may have left files in its folder. The scene is turned as the
program's .glb and .usda files are: against gravity is Blender's z. In the natural look what the scene gives a color has it, other
liquid is water and other bodies are ice; in the look of temperatures they are blue, yellow and red, whose ends are the same in all
frames of a sequence. Either way temperatures are the vertex attributes "temperature" and, for shaders, "celsius" [degrees Celsius], and the
colour attribute "warmth"; shaders of Cycles read 0 of mesh attributes that are called as those of volumes are (temperature, velocity, color, density).
Where the run wrote particles, too, the vertex attribute "velocity" [m/s] is that of the particles around, for motion blur. What is dissolved in
liquid has a vertex attribute each, "w_" and its name: its mass fraction; "liquid_fraction" is 0 where all is solid and 1 where all is liquid. In a sequence every frame is an object that is shown
in its frame alone. With --save and no file opened before, the .blend has the camera, rate and size of the run's pictures, a floor and light;
a file that is open gets the surfaces and nothing else. Debian: apt install blender python3-numpy. Arrays are handed over whole
(foreach_set), so a surface of 160,000 triangles takes a fraction of a second.
"""
import argparse
import collections
import json
import math
import os
import re
import sys
import traceback
import types

import bpy
import numpy

RAMP = numpy.array([(0.14, 0.25, 0.62), (0.27, 0.55, 0.85), (0.68, 0.86, 0.91), (0.99, 0.90, 0.45), (0.96, 0.52, 0.22),
                    (0.75, 0.09, 0.12)])
TYPES = {"float": "<f4", "int": "<i4", "uint": "<u4", "uchar": "u1"}
VECTORS = {"x": "position", "vx": "velocity", "nx": "normal"}  # what three columns are called together, by the first
FACE = numpy.dtype([("count", "u1"), ("vertices", "<u4", 3)])
VALUES = {"FLOAT": "value", "INT": "value", "FLOAT_VECTOR": "vector", "FLOAT_COLOR": "color"}  # what Blender calls them, by kind of attribute
BLENDER_UP = numpy.array([(1, 0, 0), (0, 0, -1), (0, 1, 0)])  # y becomes z, as Blender turns .glb files
CLEAR_SHARE = 0.05  # of a species in a clear liquid, from which on its colour hides what is behind, as in pictures


class RunError(Exception):
    """What can be put right outside of this script: names the thing, the value and the fix."""


# ---- What a run wrote

class Run:
    """A run's directory by its run.json: what it wrote, and how its scene is to look."""

    def __init__(self, directory):
        self.directory = os.path.abspath(directory)
        told = run_json(self.directory)
        scene = told["scene"]
        self.formats = scene["output"].get("export", [])
        self.frames, self.ended = frames_written(self.directory, told)
        self.fps = scene["time"]["fps"]
        self.spacing = scene["particles"]["spacing"]
        self.up = upward(scene["solver"]["gravity"])
        self.domain = numpy.array([scene["domain"][k] for k in ("min", "max")]) if "min" in scene["domain"] else None
        self.camera = scene["output"].get("camera", {})
        picture = scene["output"].get("picture", {})
        self.picture = picture.get("width", 960), picture.get("height", 540)
        color = {name: linear(m["color"]) if "color" in m else None for name, m in scene["materials"].items()}
        self.liquid_colors = [color.get(name) for name in told["materials"]]
        species = [name for name in told["materials"] if "dissolves_in" in scene["materials"].get(name, {})]
        # What dissolves up to a limit only, as salt does, is clear.
        self.species_colors = [color[name] if scene["materials"][name].get("solubility", 1) == 1 else None for name in species]
        bodies = scene.get("bodies", [])
        self.body_colors = [color.get(body.get("material")) for body in bodies]
        self.hidden = [k for k, body in enumerate(bodies) if not body.get("visible", True)]

    def file(self, name, frame):
        return os.path.join(self.directory, "frames", f"{name}_{frame:05}.ply")


def run_json(directory):
    if not os.path.isdir(directory):
        raise RunError(f"{directory}: there is no such directory; name the one that `meltsim run` said it is writing to")
    path = os.path.join(directory, "run.json")
    if not os.path.exists(path):
        raise RunError(f"{directory}: holds no run.json; name the directory of a run, which holds run.json and frames/")
    try:
        with open(path, encoding="utf-8") as file:
            told = json.load(file)
        told["scene"]["particles"], told["scene"]["solver"]["gravity"], told["scene"]["output"], told["materials"]
    except (ValueError, KeyError, TypeError):
        raise RunError(f"{path}: is not a whole run.json of meltsim; run the scene again") from None
    return told


def frames_written(directory, told):
    """(how many frames a run has written, whether it has ended). A run that goes on, or was killed, has a row of stats.csv for each
    frame, and the files of the last row may not be whole yet."""
    if told.get("final"):
        return told["final"]["frames"], True
    path = os.path.join(directory, "stats.csv")
    if not os.path.exists(path):
        return 0, False
    with open(path, encoding="utf-8") as file:
        return max(0, sum(1 for _ in file) - 2), False  # without the header


def surface_frames(run, every=1):
    """Numbers of the frames whose surfaces this run wrote, every one or fewer; errors say why there are none."""
    if "surface" not in run.formats:
        instead = [f", or import its .{end} files" for name, end in (("glb", "glb"), ("usd", "usda")) if name in run.formats]
        raise RunError(f"{run.directory}: this run wrote no surfaces (output.export: {', '.join(run.formats) or 'none'}); "
                       f"run it with --export surface{''.join(instead[:1])}")
    if run.frames == 0:
        raise RunError(f"{run.directory}: this run has no whole frame yet; wait for its first ones, or run it again if it was stopped")
    there = [k for k in range(0, run.frames, every) if all(os.path.exists(run.file(name, k)) for name in ("liquid", "solid"))]
    if not there:
        raise RunError(f"{os.path.join(run.directory, 'frames')}: holds none of the {run.frames} frames that run.json names; "
                       "copy the folder along with run.json, or run the scene again")
    return there


def tell(run, frames, every):
    """Says what a sequence leaves out, and why."""
    missing = len(range(0, run.frames, every)) - len(frames)
    named = (re.fullmatch(r"liquid_(\d+)\.ply", name) for name in os.listdir(os.path.join(run.directory, "frames")))
    beyond = sum(1 for found in named if found and int(found[1]) >= run.frames)
    if not run.ended:
        print(f"note: {run.directory}: this run goes on, or was killed; its {run.frames} whole frames are imported")
    if beyond and run.ended:
        print(f"note: {run.directory}: this run wrote {run.frames} frames; {beyond} of an earlier, longer run in its folder are left out")
    if missing:
        print(f"note: {run.directory}: files of {missing} frames of this run are missing; nothing is shown there")


# ---- Files

def read_rows(path):
    """The rows of vertices of a PLY file by the columns that its header names, its header, and what follows the rows."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        end = data.index(b"end_header\n") + len(b"end_header\n")
        header = data[:end].decode()
        columns = [line.split()[1:] for line in header.splitlines() if line.startswith("property") and "list" not in line]
        kind = numpy.dtype([(VECTORS[name], TYPES[of], 3) if name in VECTORS else (name, TYPES[of])
                            for of, name in columns if name[-1] not in "yz" or name[:-1] not in ("", "v", "n")])
        count = int(re.search(r"element vertex (\d+)", header)[1])
        return numpy.frombuffer(data, kind, count, end), header, data[end + count * kind.itemsize:]
    except (ValueError, TypeError, KeyError):
        raise RunError(f"{path}: is not a whole PLY file of meltsim; run the scene again") from None


def read(path):
    """(vertices, triangles, whether the file holds a placeholder) of a surface."""
    vertices, header, rest = read_rows(path)
    faces = int(re.search(r"element face (\d+)", header)[1])
    if len(rest) < faces * FACE.itemsize:
        raise RunError(f"{path}: is not a whole PLY file of meltsim; run the scene again")
    return vertices, numpy.frombuffer(rest, FACE, faces)["vertices"], "comment placeholder" in header


def read_particles(run, frame):
    """Particles of a frame (`--export ply`), or None where this run has not written them."""
    path = run.file("particles", frame)
    return read_rows(path)[0] if "ply" in run.formats and os.path.exists(path) else None


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


Part = collections.namedtuple("Part", "vertices triangles velocity")  # of a frame; velocity may be None


def read_surfaces(run, frame):
    """{"liquid": (vertices, triangles), "solid": ...} of a frame, without surfaces that hold nothing and bodies that the scene hides."""
    parts = {}
    for name in ("liquid", "solid"):
        vertices, triangles, placeholder = read(run.file(name, frame))
        if name == "solid" and run.hidden:
            triangles = triangles[~numpy.isin(vertices["body"][triangles[:, 0]], run.hidden)]
        if not placeholder and len(triangles) > 0:
            parts[name] = vertices, triangles
    return parts


def read_frame(run, frame):
    """{"liquid": Part, "solid": Part} of a frame, without surfaces that hold nothing."""
    particles = read_particles(run, frame)
    parts = {}
    for name, (vertices, triangles) in read_surfaces(run, frame).items():
        of_phase = None if particles is None else particles[particles["phase"] == ("liquid", "solid").index(name)]
        known = of_phase is not None and len(of_phase) > 0
        parts[name] = Part(vertices, triangles, velocities(vertices["position"], of_phase, 1.5 * run.spacing) if known else None)
    return parts


def temperatures(frames):
    """Coldest and hottest of the surfaces of some frames."""
    every = [part[0]["temperature"] for parts in frames for part in parts.values()] or [numpy.zeros(1)]
    return min(float(t.min()) for t in every), max(float(t.max()) for t in every)


# ---- Which way is up

def upward(gravity):
    """Against gravity, or y where there is none."""
    size = float(numpy.linalg.norm(gravity))
    return -numpy.array(gravity) / size if size > 0 else numpy.array([0.0, 1.0, 0.0])


def turn_of(run, up):
    """The matrix from the scene's axes to Blender's: the shortest turn that brings `up` to +y, as the program turns its .glb and
    .usda files, and then Blender's of such files."""
    if up not in ("auto", "x", "y", "z"):
        raise RunError(f"up: {up} is none of the scene's axes; it is auto (against gravity), x, y or z")
    x, y, z = run.up if up == "auto" else [float(up == axis) for axis in "xyz"]
    if math.hypot(x, z) + 1 + y < 1e-9:  # upside down: half a turn around x
        return BLENDER_UP @ numpy.diag((1, -1, -1))
    axis, w = numpy.array([-z, 0, x]), 1 + y  # (x, y, z) cross (0, 1, 0); a quaternion
    a, _, c = axis / math.hypot(w, x, z)
    w /= math.hypot(w, x, z)
    turn = numpy.array([(1 - 2 * c * c, -2 * c * w, 2 * a * c), (2 * c * w, 1 - 2 * (a * a + c * c), -2 * a * w),
                        (2 * a * c, 2 * a * w, 1 - 2 * a * a)])
    return BLENDER_UP @ turn


# ---- Colours and materials

def linear(color):
    """What a monitor shows (sRGB) as linear light, which Blender's colours are."""
    shown = numpy.array(color, float)
    return numpy.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def colors(temperature, cold, hot):
    x = numpy.clip((temperature - cold) / max(hot - cold, 1e-9), 0, 1) * (len(RAMP) - 1)
    shown = numpy.stack([numpy.interp(x, range(len(RAMP)), RAMP[:, k]) for k in range(3)] + [numpy.ones_like(x)], 1)
    shown[:, :3] = linear(shown[:, :3])
    return shown


def table(own):
    """Colours by number, and which numbers have one; the last row is of numbers beyond."""
    rows = numpy.array([(1, 1, 1) if color is None else color for color in own] + [(1, 1, 1)], float)
    return rows, numpy.array([color is not None for color in own] + [False])


def dyes(run, vertices, triangles):
    """(colour, share of what has one) of a liquid's vertices, averaged over their neighbours as in pictures; what is dissolved mixes
    by mass fraction, and what has no colour counts as the solvent."""
    rows, known = table(run.liquid_colors)
    number = numpy.minimum(vertices["material"], len(rows) - 1)
    share, color = known[number].astype(float), rows[number] * known[number][:, None]
    contents = [c for c in vertices.dtype.names if c.startswith("w_")]
    mixed = [(own, numpy.maximum(vertices[c], 0).astype(float)) for c, own in zip(contents, run.species_colors) if own is not None]
    if mixed:
        total = sum(w for _, w in mixed)
        added = sum(own * (w / numpy.maximum(total, 1))[:, None] for own, w in mixed)
        total = numpy.minimum(total, 1)
        seen = numpy.minimum(1, total / CLEAR_SHARE)
        alone = added * (seen / numpy.maximum(total, 1e-30))[:, None]
        color = numpy.where(known[number][:, None], color * (1 - total)[:, None] + added, alone)
        share = numpy.where(known[number], 1, seen)
    if not share.any():
        return color, share
    values = numpy.column_stack([color, share])
    to, of = triangles[:, [0, 1, 2, 0, 1, 2]].ravel(), triangles[:, [1, 2, 0, 2, 0, 1]].ravel()
    count = numpy.maximum(numpy.bincount(to, minlength=len(values)), 1)
    for _ in range(4):  # the material changes from vertex to vertex, and its edge would follow the triangles
        sums = [numpy.bincount(to, v[of], len(values)) for v in values.T]
        values = 0.5 * values + 0.5 * numpy.stack(sums, 1) / count[:, None]
    return values[:, :3] / numpy.maximum(values[:, 3:], 1e-6), values[:, 3]


def socket(shader, *names):
    """The first of these sockets that there is: Blender 4.0 renamed some."""
    return next(shader.inputs[name] for name in names if name in shader.inputs)


def material(name, build):
    """The material of this name, which build(shader, add node, link) makes where there is none yet: an artist may have changed it."""
    made = bpy.data.materials.get(name)
    if made:
        return made
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    for option in ("use_screen_refraction", "use_raytrace_refraction"):  # Eevee's, before and from Blender 4.2 on
        if hasattr(made, option):
            setattr(made, option, True)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    build(nodes.get("Principled BSDF"), nodes.new, links.new)
    return made


def attribute_node(new, name):
    source = new("ShaderNodeAttribute")
    source.attribute_name = name
    return source


def warm_material(name, alpha):
    def build(shader, new, link):
        link(attribute_node(new, "warmth").outputs["Color"], shader.inputs["Base Color"])
        shader.inputs["Alpha"].default_value = alpha
        shader.inputs["Roughness"].default_value = 0.15
    return material(name, build)


def let_light_through(shader, new, link, share):
    """Shadows of glass are black in Cycles, but for caustics: light passes where `share` (a number or a socket) says that it is clear."""
    output = next(node for node in shader.id_data.nodes if node.type == "OUTPUT_MATERIAL")
    mix, path, clear, part = (new(f"ShaderNode{kind}") for kind in ("MixShader", "LightPath", "BsdfTransparent", "Math"))
    part.operation = "MULTIPLY"
    link(path.outputs["Is Shadow Ray"], part.inputs[0])
    if isinstance(share, float):
        part.inputs[1].default_value = share
    else:
        link(share, part.inputs[1])
    clear.inputs["Color"].default_value = (0.85, 0.93, 0.95, 1)
    link(part.outputs[0], mix.inputs[0])
    link(shader.outputs[0], mix.inputs[1])
    link(clear.outputs[0], mix.inputs[2])
    link(mix.outputs[0], output.inputs["Surface"])
    return output


def water(run, extent):
    def build(shader, new, link):
        shader.inputs["Base Color"].default_value = (1, 1, 1, 1)
        shader.inputs["Roughness"].default_value = 0
        shader.inputs["IOR"].default_value = 1.333
        socket(shader, "Transmission Weight", "Transmission").default_value = 1
        output = let_light_through(shader, new, link, 0.9)
        depth = new("ShaderNodeVolumeAbsorption")  # what a depth as large as the scene takes, as in pictures
        depth.inputs["Color"].default_value = (0.07, 0.47, 0.66, 1)
        depth.inputs["Density"].default_value = 2.5 / extent
        link(depth.outputs[0], output.inputs["Volume"])
    return material("meltsim water", build)


def dyed_liquid():
    """Of liquids with colours, in part or as a whole."""
    def build(shader, new, link):
        link(attribute_node(new, "tint").outputs["Color"], shader.inputs["Base Color"])
        clear = attribute_node(new, "clear").outputs["Fac"]
        link(clear, socket(shader, "Transmission Weight", "Transmission"))
        shader.inputs["Roughness"].default_value = 0.05
        shader.inputs["IOR"].default_value = 1.333
        let_light_through(shader, new, link, clear)
    return material("meltsim dyed liquid", build)


def ice(run):
    def build(shader, new, link):
        shader.inputs["Base Color"].default_value = (0.86, 0.95, 1, 1)
        shader.inputs["Roughness"].default_value = 0.25
        shader.inputs["IOR"].default_value = 1.31
        socket(shader, "Transmission Weight", "Transmission").default_value = 0.15
        socket(shader, "Subsurface Weight", "Subsurface").default_value = 0.5
        if "Subsurface Scale" in shader.inputs:
            shader.inputs["Subsurface Scale"].default_value = run.spacing
        else:
            shader.inputs["Subsurface Radius"].default_value = (run.spacing,) * 3
    return material("meltsim ice", build)


def colored_solid():
    def build(shader, new, link):
        link(attribute_node(new, "tint").outputs["Color"], shader.inputs["Base Color"])
        shader.inputs["Roughness"].default_value = 0.4
    return material("meltsim colored solid", build)


def look_natural(run, mesh, name, part, extent):
    """Materials of a mesh, and the attributes that they show."""
    if name == "liquid":
        color, share = dyes(run, part.vertices, part.triangles)
        mesh.materials.append(dyed_liquid() if share.any() else water(run, extent))
        if share.any():
            clear = numpy.clip((0.75 - share) / 0.5, 0, 1)
            put(mesh, "clear", "FLOAT", clear)
            put(mesh, "tint", "FLOAT_COLOR", numpy.column_stack([color * (1 - clear)[:, None] + clear[:, None], numpy.ones(len(color))]))
        return
    rows, known = table(run.body_colors)
    body = numpy.where(part.vertices["body"] < len(rows), part.vertices["body"], len(rows) - 1)
    own = known[body[part.triangles[:, 0]]]
    used = [made() for made, there in ((lambda: ice(run), not own.all()), (colored_solid, own.any())) if there]
    for made in used:
        mesh.materials.append(made)
    if own.any():
        put(mesh, "tint", "FLOAT_COLOR", numpy.column_stack([rows[body], numpy.ones(len(body))]))
    if len(used) > 1:
        mesh.polygons.foreach_set("material_index", own.astype(numpy.int32))


# ---- Objects

def put(mesh, name, kind, values):
    """A vertex attribute."""
    values = numpy.ascontiguousarray(values, numpy.int32 if kind == "INT" else numpy.float32)
    mesh.attributes.new(name, kind, "POINT").data.foreach_set(VALUES[kind], values.ravel())


def mesh_of(name, points, triangles):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(points, numpy.float32).ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.astype(numpy.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("loop_total", numpy.full(len(triangles), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(len(triangles), dtype=bool))
    return mesh


Style = collections.namedtuple("Style", "look span turn extent")  # span: coldest and hottest of the colours; extent: size of what there is [m]


def add(run, name, frame, part, style):
    """The object of a surface."""
    vertices = part.vertices
    made = f"{name}_{frame:05}"
    mesh = mesh_of(made, vertices["position"] @ style.turn.T, part.triangles)
    for called in ("temperature", "celsius"):  # Cycles takes the first for one of volumes, and reads 0
        put(mesh, called, "FLOAT", vertices["temperature"])
    put(mesh, "material", "INT", vertices["material"])
    for column in (c for c in vertices.dtype.names if c == "liquid_fraction" or c.startswith("w_")):
        put(mesh, column, "FLOAT", vertices[column])
    if part.velocity is not None:
        put(mesh, "velocity", "FLOAT_VECTOR", part.velocity @ style.turn.T)
    put(mesh, "warmth", "FLOAT_COLOR", colors(vertices["temperature"], *style.span))
    if style.look == "natural":
        look_natural(run, mesh, name, part, style.extent)
    else:
        mesh.materials.append(warm_material(f"meltsim {name}", 0.5 if name == "liquid" else 1.0))
    mesh.update(calc_edges=True)
    mesh.validate()
    new = bpy.data.objects.new(made, mesh)
    bpy.context.scene.collection.objects.link(new)
    return new


def style_of(run, frames, up, span, look):
    if look not in ("natural", "temperature"):
        raise RunError(f"look: {look} is none; it is natural or temperature")
    every = None if span and run.domain is not None else [read_surfaces(run, frame) for frame in frames]
    if run.domain is not None:
        size = run.domain[1] - run.domain[0]
    else:
        points = numpy.concatenate([part[0]["position"] for parts in every for part in parts.values()] or [numpy.zeros((1, 3))])
        size = points.max(0) - points.min(0)
    return Style(look, span or temperatures(every), turn_of(run, up), max(float(numpy.linalg.norm(size)), run.spacing))


def import_frame(directory, frame, up="auto", span=None, look="natural"):
    """Objects of the liquid and of the solids of one frame; surfaces that hold nothing are left out. `up` is the scene's
    axis that becomes Blender's z, against gravity by default; `span` the temperatures at the ends of the colours, those of the frame by default."""
    run = Run(directory)
    there = surface_frames(run)
    if frame not in there:
        why = "its files are missing" if 0 <= frame < run.frames else f"this run wrote frames 0 to {run.frames - 1}"
        raise RunError(f"frame {frame}: {why} in {run.directory}; choose one from {there[0]} to {there[-1]}")
    style = style_of(run, [frame], up, span, look)
    return [add(run, name, frame, part, style) for name, part in read_frame(run, frame).items()]


def import_sequence(directory, up="auto", span=None, look="natural", every=1):
    """All frames of a run, or every second, third, ..., as an animation, which begins at Blender's frame 1 and goes as fast as the run was written."""
    if every < 1:
        raise RunError(f"every: {every} is no number of frames; it is 1 for all, 2 for every second, ...")
    run = Run(directory)
    frames = surface_frames(run, every)
    tell(run, frames, every)
    style = style_of(run, frames, up, span, look)
    made = []
    for frame in frames:
        shown = 1 + frame // every
        for new in (add(run, name, frame, part, style) for name, part in read_frame(run, frame).items()):
            for when, hidden in ((shown - 1, True), (shown, False), (shown + 1, True)):
                new.hide_render = new.hide_viewport = hidden
                new.keyframe_insert("hide_render", frame=when)
                new.keyframe_insert("hide_viewport", frame=when)
            made.append(new)
    set_rate(run, 1 + frames[-1] // every, every)
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)  # shows what belongs there
    return made


def set_rate(run, end, every=1):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, end
    scene.render.fps = max(1, round(run.fps / every))
    scene.render.fps_base = scene.render.fps / (run.fps / every)


# ---- A scene of its own, for files that are made from nothing

def bounds(objects, turn):
    """The corners of what there is to see, along the scene's axes."""
    low, high = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf)
    for made in objects:
        points = numpy.empty(3 * len(made.data.vertices), numpy.float32)
        made.data.vertices.foreach_get("co", points)
        points = points.reshape(-1, 3) @ turn
        low, high = numpy.minimum(low, points.min(0)), numpy.maximum(high, points.max(0))
    return numpy.array([low, high])


def unit(v):
    return v / max(float(numpy.linalg.norm(v)), 1e-30)


def view(run, box):
    """(eye, point looked at, axes of the picture as rows: right, above, back; angle) of the run's pictures. What output.camera
    leaves out follows from `box`, as the program has it."""
    up = unit(numpy.array(run.camera.get("up", run.up), float))
    fov = math.radians(run.camera.get("fov", 40))
    at = numpy.array(run.camera.get("look_at", box.mean(0)), float)
    if "eye" in run.camera:
        eye = numpy.array(run.camera["eye"], float)
        back = unit(eye - at)
    else:  # from in front, a little from the right and above
        towards = numpy.array([0, 0, 1] if abs(up[2]) < 0.9 else [0, -1, 0], float)
        front = unit(towards - up * (towards @ up))
        back = unit(front + numpy.cross(up, front) * 0.55 + up * 0.45)
    right = numpy.cross(up, back)
    right = unit(right if numpy.linalg.norm(right) > 1e-4 else numpy.cross(back, (-1, -0.1, 0)))
    axes = numpy.array([right, numpy.cross(back, right), back])
    if "eye" not in run.camera:  # as near as lets every corner of the box be seen
        slope, aspect = 0.88 * math.tan(0.5 * fov), min(run.picture[0] / run.picture[1], 1.4)
        corners = numpy.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        off = (corners - at) @ axes.T
        far = off[:, 2] + numpy.maximum(abs(off[:, 1]), abs(off[:, 0]) / aspect) / slope
        eye = at + back * max(far.max(), 2 * run.spacing)
    return eye, at, axes, fov


def link_object(name, data, axes=numpy.eye(3), place=(0, 0, 0)):
    """An object whose own axes are the columns of `axes`."""
    from mathutils import Matrix  # comes with bpy
    made = bpy.data.objects.new(name, data)
    made.matrix_world = Matrix([[*map(float, axes[k]), float(place[k])] for k in range(3)] + [[0, 0, 0, 1]])
    bpy.context.scene.collection.objects.link(made)
    return made


def add_camera(run, box, turn, extent):
    eye, at, axes, fov = view(run, box)
    data = bpy.data.cameras.new("meltsim camera")
    data.sensor_fit, data.angle_y = "VERTICAL", fov
    data.angle = fov
    distance = float(numpy.linalg.norm(eye - at))
    data.clip_start, data.clip_end = 0.01 * distance, distance + 100 * extent
    bpy.context.scene.camera = link_object("meltsim camera", data, turn @ axes.T, turn @ eye)
    return turn @ axes.T


def add_light(camera):
    """A sun from behind the left of the camera, as in the run's pictures, and a sky."""
    sun = bpy.data.lights.new("meltsim sun", "SUN")
    sun.energy, sun.angle = 4, 0.14
    sun.color = (1, 0.97, 0.93)
    if hasattr(sun.cycles, "use_multiple_importance_sampling"):
        sun.cycles.use_multiple_importance_sampling = False  # its mirror images within the water are specks that hundreds of samples leave
    level = camera[:, 0] * (1, 1, 0)
    across, towards = unit(level), numpy.array([0, 0, 1.0])
    back = numpy.cross(across, towards)
    z = unit(1.25 * towards - 0.75 * across + 0.55 * numpy.cross(across, towards))
    x = unit(numpy.cross(back, z))
    link_object("meltsim sun", sun, numpy.array([x, numpy.cross(z, x), z]).T)
    world = bpy.data.worlds.new("meltsim sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, link = world.node_tree.nodes, world.node_tree.links.new
    place, split, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    ramp.color_ramp.elements[0].color = (0.50, 0.56, 0.62, 1)  # of the horizon
    ramp.color_ramp.elements[1].color = (0.16, 0.26, 0.42, 1)  # above
    link(place.outputs["Generated"], split.inputs[0])
    link(split.outputs["Z"], ramp.inputs[0])
    link(ramp.outputs["Color"], nodes["Background"].inputs["Color"])


def tile_size(size):
    power = 10.0 ** math.floor(math.log10(size / 6))
    rest = size / 6 / power
    return power * (1 if rest < 2 else 2 if rest < 5 else 5)


def add_floor(run, turn, extent):
    """A chequered floor as in the run's pictures. It lies a little within the liquid: with a film of air between, water would be a mirror below."""
    corners = numpy.array([[run.domain[i, 0], run.domain[j, 1], run.domain[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) @ turn.T
    center = 0.5 * (corners.min(0) + corners.max(0))
    half = 15 * extent
    square = numpy.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    mesh = mesh_of("meltsim floor", square, numpy.array([(0, 1, 2), (0, 2, 3)]))

    def build(shader, new, link):
        place, tiles = new("ShaderNodeTexCoord"), new("ShaderNodeTexChecker")
        tiles.inputs["Color1"].default_value = (0.10, 0.11, 0.12, 1)
        tiles.inputs["Color2"].default_value = (0.22, 0.235, 0.25, 1)
        tiles.inputs["Scale"].default_value = 1 / tile_size(extent)
        link(place.outputs["Object"], tiles.inputs["Vector"])
        link(tiles.outputs["Color"], shader.inputs["Base Color"])
        shader.inputs["Roughness"].default_value = 0.7
    mesh.materials.append(material("meltsim floor", build))
    mesh.update(calc_edges=True)
    link_object("meltsim floor", mesh, place=(center[0], center[1], corners[:, 2].min() + 0.1 * run.spacing))


def set_stage(run, objects, up="auto"):
    """Camera, size of pictures, light and, where there is a domain to stand on, a floor, for a scene that has nothing else."""
    turn = turn_of(run, up)
    box = bounds(objects, turn) if objects else run.domain
    if box is None:
        return
    room = box if run.domain is None else run.domain
    extent = max(float(numpy.linalg.norm(room[1] - room[0])), run.spacing)
    add_light(add_camera(run, box, turn, extent))
    if run.domain is not None:
        add_floor(run, turn, extent)
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = run.picture
    render.resolution_percentage = 100
    render.engine = "CYCLES"  # Eevee does not bend light twice
    cycles = bpy.context.scene.cycles  # light that water focuses is grain for thousands of samples; shadows let light through instead
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.blur_glossy, cycles.sample_clamp_indirect = 0, 4
    cycles.max_bounces = cycles.transmission_bounces = 24
    cycles.samples = 128


# ---- The command line

class Parser(argparse.ArgumentParser):
    def error(self, message):  # not an exit, which would close an open Blender
        raise RunError(f"{message}; {' '.join(self.format_usage().split())}")


def options_of(arguments):
    parser = Parser(prog="import_meltsim.py --")
    parser.add_argument("directory", help="of a run")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--frame", type=int, default=0)
    which.add_argument("--sequence", action="store_true", help="all frames, as an animation")
    parser.add_argument("--every", type=int, metavar="N", help="of a sequence only every Nth frame")
    parser.add_argument("--look", choices=("natural", "temperature"), default="natural")
    parser.add_argument("--range", type=float, nargs=2, metavar=("COLD", "HOT"), help="temperatures at the ends of the colours")
    parser.add_argument("--up", choices=("auto", "x", "y", "z"), default="auto", help="the scene's axis that becomes z; auto: against gravity")
    parser.add_argument("--save", metavar="FILE.blend")
    options = parser.parse_args(arguments)
    if options.range and not options.range[0] < options.range[1]:
        raise RunError(f"--range: {options.range[0]:g} is not below {options.range[1]:g}; name the cold end first")
    if options.every is not None and not options.sequence:
        raise RunError(f"--every {options.every}: is of a sequence; add --sequence, or name one frame with --frame alone")
    folder = os.path.dirname(os.path.abspath(options.save or "."))
    if options.save and not os.path.isdir(folder):
        raise RunError(f"--save: {folder}: there is no such directory; make it first")
    return options


def main(arguments):
    options = options_of(arguments)
    run = Run(options.directory)
    surface_frames(run)
    own = bool(bpy.app.background and options.save and not bpy.data.filepath)
    if own:
        bpy.ops.wm.read_homefile(use_empty=True)
    how = {"up": options.up, "span": tuple(options.range) if options.range else None, "look": options.look}
    if options.sequence:
        imported = import_sequence(options.directory, **how, every=options.every or 1)
    else:
        imported = import_frame(options.directory, options.frame, **how)
    for made in imported:
        values = numpy.empty(len(made.data.vertices), numpy.float32)
        made.data.attributes["temperature"].data.foreach_get("value", values)
        print(f"{made.name}: {len(made.data.vertices)} vertices, {len(made.data.polygons)} triangles, "
              f"{values.min():.2f} to {values.max():.2f} degrees Celsius")
    if not imported:
        print(f"note: {run.directory}: there is neither liquid nor a body in what was to be imported")
    if own:
        set_stage(run, imported, options.up)
        if not options.sequence:
            set_rate(run, 1)
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))


def run_as_program(arguments):
    """Ends Blender with 1 after an error where nobody sits before it; one that is open stays open."""
    try:
        main(arguments)
        return
    except RunError as error:
        print(f"error: {error}", file=sys.stderr)
    except SystemExit:  # --help
        if bpy.app.background:
            raise
    except Exception:
        traceback.print_exc()
    if bpy.app.background:
        sys.stdout.flush()
        sys.exit(1)


if __name__ == "__main__":
    # The Python Console has names of its own, and imports what was run as a script by this one.
    sys.modules["import_meltsim"] = types.ModuleType("import_meltsim", __doc__)
    sys.modules["import_meltsim"].__dict__.update((name, value) for name, value in globals().items() if not name.startswith("__"))
    if "--" in sys.argv:
        run_as_program(sys.argv[sys.argv.index("--") + 1:])
    else:
        print('import_meltsim is ready; in the Python Console: from import_meltsim import import_frame, import_sequence')
