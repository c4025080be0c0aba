# SPDX-License-Identifier: Apache-2.0
"""A glTF character wades through water with ice on it: its skin is bent by its joints, as in a game, 60 times a second, and the bent mesh is a
body that pushes and warms the water.

    python character.py                                   the figure that this script makes, character.glb
    python character.py FILE.glb [--animation NAME] [--height M] [--spacing M] [--speed M/S] [--seconds S]

FILE is glTF 2.0, .glb or .gltf, with a skin and an animation; it looks along +z, as glTF has it. Needs NumPy alone. Ends in character.png if
there is matplotlib; a minute and a half of one processor."""
import argparse
import base64
import json
import struct
from pathlib import Path

import numpy as np
from meltsim import Shape, World

FPS = 60
KINDS = {"SCALAR": (1,), "VEC2": (2,), "VEC3": (3,), "VEC4": (4,), "MAT4": (4, 4)}
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


class Unusable(SystemExit):
    """What a file lacks, and what to do: a SystemExit, so that the script ends with its text."""


# ---- glTF ---------------------------------------------------------------------------------------------------------------------
class Gltf:
    """A .glb or .gltf file: its JSON and its numbers."""

    def __init__(self, path):
        self.path = Path(path)
        try:
            data, binary = self.path.read_bytes(), None
            if data[:4] == b"glTF":
                chunks, at = {}, 12
                if struct.unpack_from("<I", data, 4)[0] != 2:
                    raise Unusable(f"{path}: is glTF 1; export it as glTF 2.0 (.glb)")
                while at + 8 <= len(data):
                    size, kind = struct.unpack_from("<I4s", data, at)
                    chunks.setdefault(kind, data[at + 8:at + 8 + size])
                    at += 8 + size
                data, binary = chunks[b"JSON"], chunks.get(b"BIN\0")
            self.json = json.loads(data)
            version = str(self.json["asset"]["version"])
            if not version.startswith("2."):
                raise Unusable(f"{path}: is glTF {version}; export it as glTF 2.0 (.glb)")
            self.buffers = [self._buffer(b, binary) for b in self.json.get("buffers", [])]
        except OSError as error:
            raise Unusable(f"{path}: {error.strerror}") from None
        except (ValueError, KeyError, TypeError, struct.error):
            raise Unusable(f"{path}: is no glTF; export it as glTF 2.0 (.glb)") from None
        needed = set(self.json.get("extensionsRequired", [])) - {"KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"}
        if needed:
            raise Unusable(f"{path}: needs {', '.join(sorted(needed))}, which this script does not read; export it without compression")

    def _buffer(self, buffer, binary):
        uri = buffer.get("uri")
        if uri is None:
            return binary
        return base64.b64decode(uri.split(",", 1)[1]) if uri.startswith("data:") else (self.path.parent / uri).read_bytes()

    def array(self, index):
        """The numbers of an accessor: (count, ...), normalised ones as floats."""
        a = self.json["accessors"][index]
        if "sparse" in a:
            raise Unusable(f"{self.path}: accessor {index} is sparse, which this script does not read; export it without")
        shape, kind = KINDS[a["type"]], np.dtype(TYPES[a["componentType"]])
        width, count = int(np.prod(shape)), a["count"]
        if "bufferView" not in a:
            return np.zeros((count, *shape))
        view = self.json["bufferViews"][a["bufferView"]]
        stride = view.get("byteStride", width * kind.itemsize)
        values = np.ndarray((count, width), kind, self.buffers[view["buffer"]], view.get("byteOffset", 0) + a.get("byteOffset", 0),
                            (stride, kind.itemsize))
        if a.get("normalized"):
            values = np.maximum(values / np.iinfo(kind).max, -1)
        return np.array(values, dtype=float if kind.kind == "f" else None).reshape(count, *shape)


def rotation(q):
    """Matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def between(key, times, values, mode, time):
    """The value of an animated property: a constant, a line, on a sphere for rotations, or a cubic spline between two keys."""
    if mode == "CUBICSPLINE":  # in-tangent, value, out-tangent per key
        into, values, out = values[0::3], values[1::3], values[2::3]
    k = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, max(len(times) - 2, 0)))
    if len(times) == 1 or mode == "STEP":
        return values[int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 1))]
    span = times[k + 1] - times[k]
    s = float(np.clip((time - times[k]) / span, 0, 1))
    a, b = values[k], values[k + 1]
    if mode == "CUBICSPLINE":
        value = ((2 * s**3 - 3 * s**2 + 1) * a + span * (s**3 - 2 * s**2 + s) * out[k] + (3 * s**2 - 2 * s**3) * b
                 + span * (s**3 - s**2) * into[k + 1])
    elif key == "rotation":
        cosine = float(a @ b)
        a, cosine = (a, cosine) if cosine >= 0 else (-a, -cosine)  # the short way
        angle = np.arccos(min(cosine, 1))
        value = a + s * (b - a) if angle < 1e-4 else (np.sin((1 - s) * angle) * a + np.sin(s * angle) * b) / np.sin(angle)
    else:
        value = a + s * (b - a)
    return value / np.linalg.norm(value) if key == "rotation" else value


class Character:
    """The skinned mesh of a glTF file, closed, and where its vertices are at a time of its animation."""

    def __init__(self, path, animation=None):
        try:
            self._read(path, animation)
        except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:  # SystemExit is none of them
            raise Unusable(f"{path}: is damaged ({error!r}); export it anew as glTF 2.0 (.glb)") from None

    def _read(self, path, animation):
        self.gltf = gltf = Gltf(path)
        document, self.path = gltf.json, path
        self.nodes = document.get("nodes", [])
        skinned = [n for n in self.nodes if "skin" in n and "mesh" in n]
        if not skinned:
            raise Unusable(f"{path}: has no mesh with a skin; give it an armature, and export it with \"Skinning\"")
        skin = document["skins"][skinned[0]["skin"]]
        self.joints = skin["joints"]
        if any(document["skins"][n["skin"]]["joints"] != self.joints for n in skinned):
            raise Unusable(f"{path}: has meshes of several skins; join them to one")
        self.parent = {child: i for i, n in enumerate(self.nodes) for child in n.get("children", [])}
        self.names = [self.nodes[j].get("name", f"node {j}") for j in self.joints]
        binds = skin.get("inverseBindMatrices")
        self.inverse = np.tile(np.eye(4), (len(self.joints), 1, 1)) if binds is None else gltf.array(binds).transpose(0, 2, 1)
        self._read_mesh(skinned)
        self._read_animation(animation)

    def _read_mesh(self, skinned):
        vertices, triangles, joints, weights, first = [], [], [], [], 0
        for primitive in (p for n in skinned for p in self.gltf.json["meshes"][n["mesh"]]["primitives"]):
            attributes = primitive["attributes"]
            if "JOINTS_0" not in attributes or primitive.get("mode", 4) != 4:
                continue
            x = self.gltf.array(attributes["POSITION"]).astype(float)
            sets = [k for k in range(8) if f"JOINTS_{k}" in attributes]
            joints.append(np.hstack([self.gltf.array(attributes[f"JOINTS_{k}"]) for k in sets]))
            weights.append(np.hstack([self.gltf.array(attributes[f"WEIGHTS_{k}"]) for k in sets]))
            faces = self.gltf.array(primitive["indices"]) if "indices" in primitive else np.arange(len(x))
            vertices.append(x)
            triangles.append(faces.reshape(-1, 3).astype(int) + first)
            first += len(x)
        if not vertices:
            raise Unusable(f"{self.path}: has no triangles that follow joints")
        width = max(j.shape[1] for j in joints)
        wide = lambda rows: np.vstack([np.pad(r, ((0, 0), (0, width - r.shape[1]))) for r in rows])
        x, joints, weights = np.vstack(vertices), wide(joints).astype(int), wide(weights).astype(float)
        # Vertices stand several times where textures or normals have a seam: once is enough here.
        places = np.round((x - x.min(axis=0)) / np.ptp(x, axis=0).max() * 1e6).astype(np.int64)
        _, keep, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
        self.rest, self.which, self.share = x[keep], joints[keep], weights[keep]
        self.share = self.share / np.maximum(self.share.sum(axis=1, keepdims=True), 1e-12)
        faces = same.reshape(-1)[np.vstack(triangles)]
        self.triangles = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        edges = np.sort(np.vstack([self.triangles[:, (0, 1)], self.triangles[:, (1, 2)], self.triangles[:, (2, 0)]]), axis=1)
        once, times = np.unique(edges, axis=0, return_counts=True)
        holes = once[times % 2 == 1]
        if len(holes):
            where = self.names[int(np.bincount(self.which[holes[0, 0]], self.share[holes[0, 0]]).argmax())]
            raise Unusable(f"{self.path}: the mesh is open: {len(holes)} of {len(once)} edges have a triangle on one side only, the first at "
                           f"joint \"{where}\"; close it (Blender: Select > All by Trait > Non Manifold, then Mesh > Clean Up > Fill Holes)")

    def _read_animation(self, name):
        animations = self.gltf.json.get("animations", [])
        if not animations:
            raise Unusable(f"{self.path}: has no animation; export it with \"Animation\"")
        named = {a.get("name", f"animation {i}"): a for i, a in enumerate(animations)}
        if name is not None and name not in named:
            raise Unusable(f"{self.path}: has no animation \"{name}\"; it has {', '.join(named)}")
        self.animation, animation = (name, named[name]) if name is not None else next(iter(named.items()))
        self.tracks = []
        for channel in animation["channels"]:
            key, sampler = channel["target"]["path"], animation["samplers"][channel["sampler"]]
            if key in ("translation", "rotation", "scale") and "node" in channel["target"]:
                times, values = self.gltf.array(sampler["input"])[:, 0], self.gltf.array(sampler["output"]).astype(float)
                self.tracks.append((channel["target"]["node"], key, times, values, sampler.get("interpolation", "LINEAR")))
        if not self.tracks:
            raise Unusable(f"{self.path}: animation \"{self.animation}\" moves no joint")
        self.begin = min(t[2][0] for t in self.tracks)
        self.length = max(t[2][-1] for t in self.tracks) - self.begin

    def vertices(self, time, loop=True):
        """Where the skin is so many seconds into the animation, in the units of the file."""
        time = self.begin + (time % self.length if loop and self.length > 0 else time)
        moved = {}
        for node, key, times, values, mode in self.tracks:
            moved.setdefault(node, {})[key] = between(key, times, values, mode, time)
        known = {}

        def place(i):  # of a node in the scene
            if i not in known:
                node = {**self.nodes[i], **moved.get(i, {})}
                m = np.eye(4)
                if "matrix" in node and i not in moved:
                    m = np.array(node["matrix"], dtype=float).reshape(4, 4).T
                else:
                    m[:3, :3] = rotation(node.get("rotation", (0, 0, 0, 1))) * np.asarray(node.get("scale", (1, 1, 1)))
                    m[:3, 3] = node.get("translation", (0, 0, 0))
                known[i] = place(self.parent[i]) @ m if i in self.parent else m
            return known[i]

        of_joint = np.array([place(j) for j in self.joints]) @ self.inverse
        blended = np.einsum("vk,vkij->vij", self.share, of_joint[self.which])
        return np.einsum("vij,vj->vi", blended[:, :3, :3], self.rest) + blended[:, :3, 3]


# ---- A character of our own -----------------------------------------------------------------------------------------------------
#          name, parent, where it is [cells]
SKELETON = [("hips", None, (2.5, 6, 1)), ("chest", 0, (2.5, 9, 1)), ("head", 1, (2.5, 12.5, 1)),
            ("thigh.L", 0, (4, 6, 1)), ("shin.L", 3, (4, 3, 1)), ("thigh.R", 0, (1, 6, 1)), ("shin.R", 5, (1, 3, 1)),
            ("arm.L", 1, (5, 11, 1)), ("hand.L", 7, (8, 11, 1)), ("arm.R", 1, (0, 11, 1)), ("hand.R", 9, (-3, 11, 1))]
ENDS = {2: (2.5, 15, 1), 4: (4, 0, 1), 6: (1, 0, 1), 8: (11, 11, 1), 10: (-6, 11, 1)}  # of bones without a child
CELL = 0.075  # m


def figure():
    """A closed mesh around blocks of cells, smoothed, with arms held out: vertices [cells], triangles."""
    cells = set()
    for x, y, z in (((3, 5), (0, 6), (0, 2)), ((0, 2), (0, 6), (0, 2)), ((0, 5), (6, 12), (0, 2)), ((5, 11), (10, 12), (0, 2)),
                    ((-6, 0), (10, 12), (0, 2)), ((1, 4), (12, 15), (0, 2))):
        cells |= {(i, j, k) for i in range(*x) for j in range(*y) for k in range(*z)}
    number, triangles = {}, []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beside = list(cell)
                beside[axis] += 2 * side - 1
                if tuple(beside) in cells:
                    continue
                corners = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)) if side else ((0, 0), (0, 1), (1, 1), (1, 0)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[(axis + 1) % 3] += u
                    corner[(axis + 2) % 3] += v
                    corners.append(number.setdefault(tuple(corner), len(number)))
                triangles += [corners[:3], [corners[0], *corners[2:]]]
    x, triangles = np.array(list(number), dtype=float), np.array(triangles)
    edges = np.unique(np.sort(np.vstack([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]]), axis=1), axis=0)
    for _ in range(2):
        total, count = np.zeros_like(x), np.zeros(len(x))
        for a, b in (edges.T, edges.T[::-1]):
            np.add.at(total, a, x[b])
            np.add.at(count, a, 1)
        x = 0.6 * x + 0.4 * total / count[:, None]
    return x, triangles


def bone_weights(x):
    """The four bones that are nearest to each vertex, and their shares."""
    distance = []
    for i, (_, _, begin) in enumerate(SKELETON):
        child = next((c[2] for c in SKELETON if c[1] == i and i not in (0, 1)), ENDS.get(i, SKELETON[min(i + 1, 2)][2]))
        a, b = np.array(begin, dtype=float), np.array(child, dtype=float)
        t = np.clip((x - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        distance.append(np.linalg.norm(x - a - t[:, None] * (b - a), axis=1))
    share = 1 / (np.array(distance).T ** 6 + 1e-3)
    four = np.argsort(-share, axis=1)[:, :4]
    share = np.take_along_axis(share, four, axis=1)
    return four, share / share.sum(axis=1, keepdims=True)


def about(axis, degrees):
    """A turn about x, y or z as a quaternion x, y, z, w."""
    half = np.radians(degrees) / 2
    return np.array([*(np.sin(half) * np.eye(3)[axis]), np.cos(half)])


def times(p, q):
    """The turn q, then p."""
    return np.array([*(p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3])), p[3] * q[3] - p[:3] @ q[:3]])


def stride(phase):
    """Turns of the joints and how high the hips are [cells], at a phase of two steps: the leg that is behind swings forward with a bent knee."""
    swing = np.sin(phase)
    turns = {}
    for side, way in (("L", 1), ("R", -1)):
        turns["thigh." + side] = about(0, -28 * way * swing)  # forward is +z
        turns["shin." + side] = about(0, 45 * max(0.0, way * np.cos(phase)))
        turns["arm." + side] = times(about(0, 30 * way * swing), about(2, -72 * way))
        turns["hand." + side] = about(1, -25 * way)
    return turns, 6 * (np.cos(np.radians(28 * swing)) - 1)


def write_figure(path, seconds=1.5, keys=24):
    """Our own character as .glb: mesh, skin, skeleton, and a walk on the spot of two steps."""
    x, triangles = figure()
    joints, weights = bone_weights(x)
    views, accessors, data = [], [], bytearray()

    def add(values, kind, component, **more):
        data.extend(b"\0" * (-len(data) % 4))
        raw = np.ascontiguousarray(values, dtype=TYPES[component]).tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(raw)})
        data.extend(raw)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind, **more})
        return len(accessors) - 1

    metres = x * CELL
    primitive = {"attributes": {"POSITION": add(metres, "VEC3", 5126, min=metres.min(axis=0).tolist(), max=metres.max(axis=0).tolist()),
                                "JOINTS_0": add(joints, "VEC4", 5121), "WEIGHTS_0": add(weights, "VEC4", 5126)},
                 "indices": add(triangles.reshape(-1, 1), "SCALAR", 5125)}
    place = np.array([p for _, _, p in SKELETON]) * CELL
    inverse = np.tile(np.eye(4), (len(SKELETON), 1, 1))
    inverse[:, :3, 3] = -place
    binds = add(inverse.transpose(0, 2, 1), "MAT4", 5126)
    nodes = [{"name": name, "translation": (place[i] - (place[parent] if parent is not None else 0)).tolist()}
             for i, (name, parent, _) in enumerate(SKELETON)]
    for i, (_, parent, _) in enumerate(SKELETON):
        if parent is not None:
            nodes[parent].setdefault("children", []).append(i)
    nodes.append({"name": "figure", "mesh": 0, "skin": 0})
    at = np.linspace(0, 1, keys + 1)
    poses = [stride(2 * np.pi * t) for t in at]
    clock = add((at * seconds)[:, None], "SCALAR", 5126, min=[0], max=[seconds])
    samplers = [{"input": clock, "output": add([place[0] + (0, h * CELL, 0) for _, h in poses], "VEC3", 5126)}]
    channels = [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
    for name in poses[0][0]:
        samplers.append({"input": clock, "output": add([turns[name] for turns, _ in poses], "VEC4", 5126)})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": [n for n, _, _ in SKELETON].index(name), "path": "rotation"}})
    document = {"asset": {"version": "2.0", "generator": "meltsim examples/python/character.py"}, "scene": 0,
                "scenes": [{"nodes": [0, len(nodes) - 1]}], "nodes": nodes, "meshes": [{"primitives": [primitive]}],
                "skins": [{"joints": list(range(len(SKELETON))), "inverseBindMatrices": binds}],
                "animations": [{"name": "walk", "samplers": samplers, "channels": channels}],
                "buffers": [{"byteLength": len(data)}], "bufferViews": views, "accessors": accessors}
    text = json.dumps(document).encode()
    text, data = text + b" " * (-len(text) % 4), bytes(data) + b"\0" * (-len(data) % 4)
    Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text
                           + struct.pack("<I4s", len(data), b"BIN\0") + data)


# ---- In the World ---------------------------------------------------------------------------------------------------------------
def thickness(x, triangles):
    """Of the mesh behind each triangle: the way from its middle inwards to the other side."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    if np.einsum("ij,ij->", a, normal) < 0:
        normal = -normal  # turned inside out
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    middle, e1, e2 = (a + b + c) / 3, b - a, c - a
    found = np.full(len(triangles), np.inf)
    for i in range(len(triangles)):
        way = -normal[i]
        p = np.cross(way, e2)
        det = np.einsum("ij,ij->i", e1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = middle[i] - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, e1)
            v, t = q @ way / det, np.einsum("ij,ij->i", e2, q) / det
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9 * np.abs(x).max())
        hit[i] = False
        if hit.any():
            found[i] = t[hit].min()
    return found


class Walker:
    """A character in space: it stands on `floor`, as tall as `height`, and walks along +z from `start`."""

    def __init__(self, character, height, floor, start, speed):
        first = character.vertices(0)
        self.character, self.scale, self.speed = character, height / np.ptp(first[:, 1]), speed
        lowest = min(character.vertices(t)[:, 1].min() for t in np.linspace(0, character.length, 25))
        middle = (first.min(axis=0) + first.max(axis=0)) / 2
        self.offset = np.array((start[0] - middle[0] * self.scale, floor - lowest * self.scale, start[1] - middle[2] * self.scale))
        # Played over and over if its end goes on at its beginning, else once.
        gap = np.abs(character.vertices(character.length, False) - first).max() * self.scale
        self.loops = gap < 0.02 * height

    def at(self, time):
        """All vertices [m], (n, 3). It starts from rest and walks as fast as it should after a second."""
        time = 0.5 * time * time if time < 1 else time - 0.5
        shown = time if self.loops else min(time, self.character.length)
        return self.character.vertices(shown, self.loops) * self.scale + self.offset + (0, 0, self.speed * time)

    def fastest(self, seconds):
        """Of its vertices [m/s]."""
        places = [self.at(k / FPS) for k in range(round(seconds * FPS) + 1)]
        return max((np.linalg.norm(b - a, axis=1).max() for a, b in zip(places, places[1:])), default=0) * FPS


def check_features(walker, spacing):
    """Refuses parts that the lattice cannot show: half of what follows a joint is thinner than two spacings."""
    character, x = walker.character, walker.at(0)
    thick = thickness(x, character.triangles)
    lead = character.which[np.arange(len(x)), character.share.argmax(axis=1)]
    thin = {name: np.median(thick[(lead[character.triangles] == j).any(axis=1)])
            for j, name in enumerate(character.names) if (lead[character.triangles] == j).any()}
    name = min(thin, key=thin.get)
    if thin[name] < 2 * spacing:
        tall = np.ptp(x[:, 1]) * 2 * spacing / thin[name]
        raise Unusable(f"{character.path}: at joint \"{name}\" it is {thin[name]:.3g} m thick, less than two spacings of {spacing:g} m, so liquid "
                       f"would pass; take --spacing {0.48 * thin[name]:.2g} or less, or --height {np.ceil(tall * 100) / 100:g} or more")


def build(path, animation=None, height=1.15, spacing=0.05, speed=0.6, seconds=3.0, depth=0.5, threads=0):
    character = Character(path, animation)
    size = np.array((1.2, 1.4, 1.2 + max(speed, 0) * seconds)) * height / 1.15
    walker = Walker(character, height, 0.5 * spacing, (size[0] / 2, 0.5 * height), speed)
    check_features(walker, spacing)
    low = np.min([walker.at(t).min(axis=0) for t in np.linspace(0, seconds, 30)], axis=0)
    high = np.max([walker.at(t).max(axis=0) for t in np.linspace(0, seconds, 30)], axis=0)
    low, high = np.minimum(low - spacing, 0), np.maximum(high + 2 * spacing, size)  # of the tank
    low[1] = 0
    world = World(spacing=spacing, domain=(tuple(np.floor(low / spacing) * spacing), tuple(np.ceil(high / spacing) * spacing)), backend="automatic",
                  threads=threads, heat_time_scale=2e4)
    world.add_material("water", viscosity=0.001, conductivity=0.6, heat_capacity=4186)
    world.add_material("ice", density=917, melting_point=0, latent_heat=3.34e5, becomes="water", conductivity=2.2, heat_capacity=2100)
    world.add_material("clay", density=2000, conductivity=1, heat_capacity=900)
    world.add_solid(Shape.mesh(walker.at(0), character.triangles), "clay", name="character", motion="kinematic", temperature=90,
                    max_speed=1.2 * walker.fastest(seconds) + 0.1)
    side = 4 * spacing
    for z in np.arange(0.5 * height + 0.6, high[2] - side, 0.7):
        for x in (0.3 * size[0], 0.7 * size[0]):
            corner = np.round(np.array((x - side / 2, depth - side / 2, z)) / spacing) * spacing
            world.add_solid(Shape.box(tuple(corner), tuple(corner + side)), "ice", temperature=-2)
    world.add_fluid(Shape.box(tuple(low), (high[0], depth, high[2])), "water", temperature=30)
    world.watch_forces("character")
    return world, walker


def walk(world, walker, seconds, every=None):
    """Steps so long. Returns [time, force on it along its way, N] per frame; every(frame) is called beside."""
    record = []
    for frame in range(round(seconds * FPS)):
        then, ahead = walker.at(world.time + 1 / FPS), walker.at(world.time + 2 / FPS)
        world.update_mesh("character", then, (ahead - then) * FPS)
        world.step(1 / FPS)
        record.append((world.time, world.take_forces()["character"]["impulse"][2] * FPS))
        if every is not None:
            every(frame)
    if world.synchronize().halted:
        raise SystemExit("the simulation has halted")
    return np.array(record)


def inside(world, walker):
    """How far within the mesh particles of liquid have their centres [m]: from points on it, a tenth of a triangle apart."""
    p, skin, triangles = world.particles(), walker.at(world.time), walker.character.triangles
    liquid = p.position[np.asarray(p.liquid_fraction) > 0.5]
    near = liquid[((liquid > skin.min(axis=0)) & (liquid < skin.max(axis=0))).all(axis=1)]
    a, b, c = (skin[triangles[:, k]] for k in range(3))
    shares = np.array([(i, j, 10 - i - j) for i in range(11) for j in range(11 - i)]) / 10
    on_it, depths = np.einsum("sk,ktd->std", shares, np.array((a, b, c))).reshape(-1, 3), []
    for x in near:  # the mesh fills a solid angle of 4 pi from inside, 0 from outside
        u, v, w = a - x, b - x, c - x
        lu, lv, lw = (np.linalg.norm(r, axis=1) for r in (u, v, w))
        dot = lambda r, s: np.einsum("ij,ij->i", r, s)
        angle = 2 * np.arctan2(dot(u, np.cross(v, w)), lu * lv * lw + dot(u, v) * lw + dot(v, w) * lu + dot(w, u) * lv).sum()
        if abs(angle) > 2 * np.pi:
            depths.append(np.linalg.norm(on_it - x, axis=1).min())
    return np.array(depths)


def draw(shots, walker, picture):
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    except ImportError:
        return print("no matplotlib: no picture")
    figure = plt.figure(figsize=(5 * len(shots), 4.6), layout="constrained")
    sun = np.array((0.5, 0.7, -0.5)) / np.sqrt(0.99)
    for k, (time, skin, surfaces) in enumerate(shots):
        axis = figure.add_subplot(1, len(shots), k + 1, projection="3d", computed_zorder=False)
        meshes = [(skin, walker.character.triangles, (0.8, 0.5, 0.2), 1.0)]
        for position, triangle, body in surfaces:
            of = body[triangle[:, 0]]  # 0 liquid, 1 the character, whose skin is finer, then ice
            meshes += [(position, triangle[of > 1], (0.95, 0.97, 1.0), 1.0), (position, triangle[of == 0], (0.2, 0.5, 0.8), 0.25)]
        for order, (x, triangles, color, opacity) in enumerate(meshes):
            corners = x[triangles]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            light = 0.55 + 0.45 * np.abs(normal @ sun) / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)
            axis.add_collection3d(Poly3DCollection(corners[:, :, (2, 0, 1)], facecolors=np.c_[light[:, None] * color, np.full(len(light), opacity)],
                                                   zorder=order))
        low, high = np.min([x.min(axis=0) for x, *_ in meshes], axis=0), np.max([x.max(axis=0) for x, *_ in meshes], axis=0)
        axis.set(xlim=(low[2], high[2]), ylim=(low[0], high[0]), zlim=(0, high[1]), title=f"{time:.1f} s")
        axis.set_box_aspect((high - low)[[2, 0, 1]])
        axis.view_init(18, -62)
        axis.set_axis_off()
    figure.savefig(picture, dpi=90, bbox_inches="tight")
    print(picture)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", help="a .glb or .gltf file with a skin and an animation; none: character.glb is made")
    parser.add_argument("--animation", help="its name; the first one by default")
    parser.add_argument("--height", type=float, default=1.15, help="of the character at the start [m]")
    parser.add_argument("--spacing", type=float, default=0.05, help="of particles [m]")
    parser.add_argument("--speed", type=float, default=0.6, help="of its way along +z [m/s]")
    parser.add_argument("--seconds", type=float, default=3.0)
    given = parser.parse_args(arguments)
    for name in ("height", "spacing", "seconds"):
        if not 0 < getattr(given, name) < np.inf:
            parser.error(f"--{name}: must be above 0, got {getattr(given, name)}")
    if given.file is None:
        given.file = "character.glb"
        write_figure(given.file)
    world, walker = build(given.file, given.animation, given.height, given.spacing, given.speed, given.seconds, 0.43 * given.height)
    character = walker.character
    print(f"{given.file}: {len(character.triangles)} triangles, {len(character.joints)} joints, animation \"{character.animation}\" of "
          f"{character.length:.2f} s, played {'over and over' if walker.loops else 'once'}")
    ice = world.synchronize().solid
    shots, frames = [], round(given.seconds * FPS)

    def look(frame):
        if frame + 1 in (frames // 6, frames // 2, frames):
            s = [world.surface(), world.surface("solids")]
            shots.append((world.time, walker.at(world.time), [(np.asarray(m.position), np.asarray(m.triangles), np.asarray(m.body)) for m in s]))

    record = walk(world, walker, given.seconds, look)
    depths = inside(world, walker)
    print(f"mean drag of the second half: {-record[len(record) // 2:, 1].mean():.0f} N; ice melted: {ice - world.synchronize().solid} particles; "
          f"liquid within the mesh: {len(depths)} particles, {depths.max(initial=0) / given.spacing:.2f} spacings deep at most")
    draw(shots, walker, "character.png")


if __name__ == "__main__":
    main()
