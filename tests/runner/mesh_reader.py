# SPDX-License-Identifier: Apache-2.0
"""Reads the surfaces that runs write, with nothing but the standard library."""
import json
import re
import struct
from pathlib import Path

ARRAYS = {5126: "f", 5125: "I"}
WIDTH = {"SCALAR": 1, "VEC3": 3}


class Mesh:
    """vertices: (x, y, z, nx, ny, nz, temperature, body, material, liquid fraction, mass fraction of each species); faces: (a, b, c)"""

    def __init__(self, vertices, faces, placeholder):
        self.vertices, self.faces, self.placeholder = vertices, faces, placeholder


def read_mesh(path):
    data = Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode("ascii").splitlines()
    assert header[:2] == ["ply", "format binary_little_endian 1.0"]
    count = {words[1]: int(words[2]) for line in header if (words := line.split())[0] == "element"}
    fields = [line.split()[2] for line in header if line.startswith("property") and "list" not in line]
    assert fields[:10] == ["x", "y", "z", "nx", "ny", "nz", "temperature", "body", "material", "liquid_fraction"], fields
    assert all(field.startswith("w_") for field in fields[10:]), fields
    middle = end + 4 * len(fields) * count["vertex"]
    vertices = list(struct.iter_unpack(f"<7f2i{len(fields) - 9}f", data[end:middle]))
    faces = list(struct.iter_unpack("<B3I", data[middle:]))
    assert len(vertices) == count["vertex"] and len(faces) == count["face"]
    assert all(face[0] == 3 for face in faces)
    return Mesh(vertices, [face[1:] for face in faces], any("placeholder" in line for line in header))


def read_obj(path):
    """(positions, colours, temperatures, normals, faces)"""
    rows = {"v": [], "vt": [], "vn": [], "f": []}
    for line in Path(path).read_text().splitlines():
        kind, *words = line.split() or ["#"]
        if kind in rows:
            rows[kind].append(words)
    numbers = [[float(word) for word in row] for row in rows["v"]]
    faces = [tuple(int(word.split("/")[0]) - 1 for word in row) for row in rows["f"]]
    assert all(len(set(word.split("/"))) == 1 for row in rows["f"] for word in row)
    return ([n[:3] for n in numbers], [n[3:] for n in numbers], [float(row[0]) for row in rows["vt"]],
            [[float(word) for word in row] for row in rows["vn"]], faces)


def read_glb(path):
    """{name of node: {attribute: values}}; checks what a validator would: lengths, alignment, bounds, names, and that all is used."""
    data = Path(path).read_bytes()
    magic, version, length, head, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON") and head % 4 == 0
    tree = json.loads(data[20:20 + head])
    size, kind = struct.unpack_from("<I4s", data, 20 + head)
    assert kind == b"BIN\0" and size % 4 == 0 and 28 + head + size == len(data)
    block = data[28 + head:]
    assert 0 <= size - tree["buffers"][0]["byteLength"] < 4

    used = set()

    def values(index):
        used.add(index)
        accessor = tree["accessors"][index]
        view = tree["bufferViews"][accessor["bufferView"]]
        width, letter = WIDTH[accessor["type"]], ARRAYS[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == 4 * width * accessor["count"]
        assert view["byteOffset"] + view["byteLength"] <= size
        flat = struct.unpack_from(f"<{width * accessor['count']}{letter}", block, view["byteOffset"])
        rows = [flat[i:i + width] for i in range(0, len(flat), width)]
        if "min" in accessor:
            for axis in range(width):
                assert abs(min(row[axis] for row in rows) - accessor["min"][axis]) < 1e-6
                assert abs(max(row[axis] for row in rows) - accessor["max"][axis]) < 1e-6
        return rows

    nodes = {}
    left = [(index, None) for index in tree["scenes"][tree["scene"]]["nodes"]]
    for index, rotation in left:
        node = tree["nodes"][index]
        left += [(child, node["rotation"]) for child in node.get("children", [])]
        if "mesh" not in node:
            continue
        found = nodes[node["name"]] = {"translation": node["translation"], "rotation": rotation, "indices": [], "parts": [], "materials": {}}
        for primitive in tree["meshes"][node["mesh"]]["primitives"]:
            found.update({name: values(at) for name, at in primitive["attributes"].items()})
            for name, at in primitive["attributes"].items():
                own = re.fullmatch("_[A-Z][A-Z0-9_]*", name)
                assert name in ("POSITION", "NORMAL", "COLOR_0") or own, name
                assert tree["accessors"][at]["componentType"] == 5126 and len(found[name]) == len(found["POSITION"]), name
            indices = [row[0] for row in values(primitive["indices"])]
            assert len(indices) % 3 == 0 and max(indices) < len(found["POSITION"])
            found["indices"] += indices
            material = tree["materials"][primitive["material"]]
            found["materials"][material["name"]] = material
            found["parts"].append((material["name"], material["pbrMetallicRoughness"]["baseColorFactor"],
                                   "COLOR_0" in primitive["attributes"], indices))
    assert used == set(range(len(tree["accessors"]))) and len(tree["bufferViews"]) == len(tree["accessors"])
    assert {m["name"] for m in tree["materials"]} == {name for found in nodes.values() for name in found["materials"]}
    extensions = {name for m in tree["materials"] for name in m.get("extensions", {})}
    assert extensions == set(tree.get("extensionsUsed", [])) and "extensionsRequired" not in tree
    return nodes
