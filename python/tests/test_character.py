# SPDX-License-Identifier: Apache-2.0
"""The glTF character of the examples: its skin is where its joints put it, the body follows it, liquid stays out; files that cannot be one."""
import importlib.util
import json
import struct
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("character", Path(__file__).parents[2] / "examples" / "python" / "character.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def figure(example, tmp_path):
    example.write_figure(tmp_path / "figure.glb")
    return tmp_path / "figure.glb"


def rewrite(path, change):
    """The same .glb with another JSON."""
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + size])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size:]
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest)
    return path


def test_the_skin_follows_its_joints(example, figure):
    character = example.Character(figure)
    assert 300 < len(character.triangles) < 1000 and character.length == 1.5
    # A vertex of one joint alone goes where that joint goes: the knee hangs on the thigh, which turns about the hip.
    knee, thigh = (character.names.index(name) for name in ("shin.L", "thigh.L"))
    character.which[:2], character.share[:2] = 0, 0
    character.which[:2, 0], character.share[:2, 0] = (thigh, knee), 1
    character.rest[:2] = np.array([(4, 3, 1), (4, 0, 1)]) * example.CELL  # the knee, the end of the shin
    hip = np.array((4, 6, 1)) * example.CELL
    for time in (0.0, 0.2, 0.375, 1.0):
        phase = 2 * np.pi * time / character.length
        at = character.vertices(time)[:2]
        swing, bend = np.radians(28 * np.sin(phase)), np.radians(45 * max(0, np.cos(phase)))
        lift = (6 * (np.cos(swing) - 1)) * example.CELL
        expected = hip + (0, lift, 0) + 3 * example.CELL * np.array((0, -np.cos(swing), np.sin(swing)))
        # Turns are interpolated between 24 keys: half the square of a step of 15 degrees of phase, of 28 degrees.
        assert np.allclose(at[0], expected, atol=5e-3 * example.CELL * 3)
        foot = expected + 3 * example.CELL * np.array((0, -np.cos(swing - bend), np.sin(swing - bend)))
        assert np.allclose(at[1], foot, atol=0.03 * example.CELL * 6)


def test_seams_are_sewn(example, figure, tmp_path, monkeypatch):
    whole = example.Character(figure)
    x, triangles = example.figure()
    monkeypatch.setattr(example, "figure", lambda: (x[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)))  # as with flat shading
    example.write_figure(tmp_path / "flat.glb")
    sewn = example.Character(tmp_path / "flat.glb")
    assert len(sewn.rest) == len(whole.rest) and len(sewn.triangles) == len(whole.triangles)
    a, b = whole.vertices(0.4), sewn.vertices(0.4)
    assert np.abs(a[:, None] - b).max(axis=2).min(axis=1).max() < 1e-6


def test_keys_are_interpolated(example):
    times, turns = np.array([0.0, 1.0, 3.0]), np.array([example.about(1, a) for a in (0, 90, 350)])
    assert np.allclose(example.between("rotation", times, turns, "LINEAR", 0.5), example.about(1, 45))
    # From 90 to 350 degrees the short way, by -100.
    assert abs(example.between("rotation", times, turns, "LINEAR", 2.0) @ example.about(1, 40)) == pytest.approx(1)
    points = np.array([[0.0], [2.0], [4.0]])
    assert [example.between("scale", times, points, mode, 2.0)[0] for mode in ("LINEAR", "STEP")] == [3.0, 2.0]
    assert [example.between("scale", times, points, "LINEAR", t)[0] for t in (-1, 9)] == [0.0, 4.0]
    spline = np.array([[0.0], [0.0], [6.0], [0.0], [2.0], [0.0], [0.0], [4.0], [0.0]])  # tangents 6 and 0 at the ends of the first second
    assert example.between("scale", times, spline, "CUBICSPLINE", 0.5)[0] == pytest.approx(0.5 * 2 + 0.125 * 6)


def test_a_character_wades(example, figure):
    spacing, seconds = 0.07, 1.0
    world, walker = example.build(figure, spacing=spacing, seconds=seconds, threads=1)
    before = world.particles()
    body = before.body == list(world.bodies).index("character")
    assert body.sum() > 150
    record = example.walk(world, walker, seconds)
    after = world.particles()
    # Its particles went where the skin beside them went, which is up to two spacings off and turns: by 0.16 and 0.48
    # spacings of it when this was written.
    skin, start = walker.at(world.time), walker.at(0)
    went = (after.position - before.position)[body]
    near = np.linalg.norm(before.position[body][:, None] - start, axis=2).argmin(axis=1)
    off = np.linalg.norm(went - (skin - start)[near], axis=1) / spacing
    assert off.mean() < 0.25 and np.percentile(off, 95) < 0.7
    # It has walked, and its feet have swung against its hips.
    assert went[:, 2].mean() == pytest.approx(0.6 * (seconds - 0.5), rel=0.05) and np.ptp(went[:, 2]) > 0.3
    # Liquid stays out: what is within the skin is as near to it as a lattice can tell within from beside (0.51 spacings when this was written).
    depths = example.inside(world, walker)
    assert depths.max(initial=0) < 0.75 * spacing and len(depths) < 0.15 * body.sum()
    # It pushes what is before it, and is held back.
    wet = np.asarray(after.liquid_fraction) > 0.5
    ahead = wet & (np.abs(after.position - skin.mean(axis=0)) < (0.3, 0.6, 0.3)).all(axis=1)
    assert after.velocity[ahead, 2].mean() > 0.06 > 2 * abs(after.velocity[wet & ~ahead, 2].mean())
    assert record[len(record) // 2:, 1].mean() < -40


def without_skin(document):
    del document["nodes"][-1]["skin"]


def without_animation(document):
    del document["animations"]


def with_a_hole(document):
    document["accessors"][3]["count"] -= 3


def compressed(document):
    document["extensionsRequired"] = ["KHR_draco_mesh_compression"]


@pytest.mark.parametrize("change, text", [
    (without_skin, "has no mesh with a skin"), (without_animation, "has no animation"),
    (with_a_hole, r"the mesh is open: 3 of \d+ edges .* at joint \".*\"; close it"), (compressed, "KHR_draco_mesh_compression")])
def test_what_a_file_lacks_is_said(example, figure, change, text):
    with pytest.raises(SystemExit, match=text):
        example.Character(rewrite(figure, change))


def test_what_does_not_fit_is_said(example, figure, tmp_path):
    with pytest.raises(SystemExit, match=r"0\.14\d* m thick, less than two spacings of 0.1 m.*--spacing 0.0\d+ or less, or --height 1\.\d+"):
        example.build(figure, spacing=0.1)
    with pytest.raises(SystemExit, match='has no animation "run"; it has walk'):
        example.Character(figure, "run")
    with pytest.raises(SystemExit, match="No such file"):
        example.Character(tmp_path / "none.glb")
    for data in (b"", b"solid cube", b"glTF\2\0\0\0", b"glTF\1\0\0\0" + bytes(8), figure.read_bytes()[:5000]):
        (tmp_path / "broken.glb").write_bytes(data)
        with pytest.raises(SystemExit, match="broken.glb: is (no glTF|glTF 1|damaged)"):
            example.Character(tmp_path / "broken.glb")
