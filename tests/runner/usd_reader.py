# SPDX-License-Identifier: Apache-2.0
"""usd_reader.py MELTSIM SCENE: runs with --export usd, opened by USD itself (usd-core from PyPI): each frame, and the run that
scene.usda joins them to. Ends with 77 where that is not installed."""
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    from pxr import Usd, UsdGeom, UsdShade
except ImportError:
    print("usd-core is not installed: pip install usd-core")
    sys.exit(77)
try:
    from pxr import UsdValidation
except ImportError:
    UsdValidation = None  # earlier versions of USD

meltsim, scene = sys.argv[1:3]
SURFACES = ("liquid", "solid")
PRIMVARS = ("temperature", "liquid_fraction", "body", "material")


def frames_of(out):
    return {int(path.name.split(".")[1]): path for path in sorted((out / "frames").glob("scene.*.usda"))}


def check_valid(path):
    if UsdValidation is None:
        return
    stage = Usd.Stage.Open(str(path))
    errors = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage)
    assert not errors, [(path.name, error.GetName(), error.GetMessage()) for error in errors]


def check_frame(path, index):
    """What one file says, at its time code; returns the number of particles."""
    stage = Usd.Stage.Open(str(path))
    assert stage.GetDefaultPrim().GetName() == "meltsim" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetStartTimeCode() == stage.GetEndTimeCode() == index and stage.GetTimeCodesPerSecond() == 25
    points = UsdGeom.Points(stage.GetPrimAtPath("/meltsim/particles"))
    n = len(points.GetPointsAttr().Get(index))
    assert len(points.GetIdsAttr().Get(index)) == n and len(points.GetVelocitiesAttr().Get(index)) == n
    for name in PRIMVARS:
        primvar = UsdGeom.PrimvarsAPI(points).GetPrimvar(name)
        assert primvar.GetInterpolation() == "vertex" and len(primvar.Get(index)) == n, name
    if n > 0:
        # Particles reach half a width around their places.
        low = [min(p[k] for p in points.GetPointsAttr().Get(index)) for k in range(3)]
        extent, half = points.GetExtentAttr().Get(index), points.GetWidthsAttr().Get(index)[0] / 2
        assert all(extent[0][k] < low[k] - half + 1e-6 for k in range(3))
        assert index > 0 or all(abs(extent[0][k] - (low[k] - half)) < 1e-6 for k in range(3))
    for name in SURFACES:
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/meltsim/{name}"))
        attributes = (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
        vertices, counts, indices = (a.Get(index) for a in attributes)
        assert set(counts) <= {3} and len(indices) == 3 * len(counts) and max(indices, default=-1) < len(vertices)
        assert len(mesh.GetNormalsAttr().Get(index)) == len(vertices)
        for primvar in PRIMVARS:
            assert len(UsdGeom.PrimvarsAPI(mesh).GetPrimvar(primvar).Get(index)) == len(vertices), primvar
        assert UsdGeom.Mesh.ValidateTopology(indices, counts, len(vertices))[0]
        # Every face is of one material.
        parts = [prim for prim in mesh.GetPrim().GetChildren() if prim.IsA(UsdGeom.Subset)]
        faces = [i for prim in parts for i in UsdGeom.Subset(prim).GetIndicesAttr().Get(index)]
        assert not parts or sorted(faces) == list(range(len(counts)))
        for prim in parts or [mesh.GetPrim()]:
            assert UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0], prim.GetPath()
        color = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayColor")
        assert len(color.Get(index)) == (1 if color.GetInterpolation() == "constant" else len(vertices))
    return n


def check_extents(joined, frames):
    """At the frames and between them, where points stay and extents are interpolated, each bounds what is shown."""
    for name in ("particles", *SURFACES):
        shown = UsdGeom.PointBased(joined.GetPrimAtPath(f"/meltsim/{name}"))
        for code in (index + part for index in frames for part in (0, 0.1, 0.5, 0.9) if index + part <= max(frames)):
            extent, points = shown.GetExtentAttr().Get(code), shown.GetPointsAttr().Get(code)
            assert all(abs(c) < 1e6 for corner in extent for c in corner), (name, code, extent)
            for k in range(3):
                assert extent[0][k] <= extent[1][k], (name, code, extent)
                assert not points or extent[0][k] - 1e-6 <= min(p[k] for p in points), (name, code, extent)
                assert not points or extent[1][k] + 1e-6 >= max(p[k] for p in points), (name, code, extent)


def check_joined(out):
    """scene.usda has all that each frame has, at the frame's time code."""
    frames = frames_of(out)
    joined = Usd.Stage.Open(str(out / "scene.usda"))
    span = (joined.GetStartTimeCode(), joined.GetEndTimeCode())
    assert span == (min(frames), max(frames)) and sorted(frames) == list(range(max(frames) + 1)), (span, list(frames))
    assert joined.GetTimeCodesPerSecond() == joined.GetFramesPerSecond() == 25
    for index, path in frames.items():
        frame = Usd.Stage.Open(str(path))  # prims live as long as their stage does
        for prim in frame.Traverse():
            other = joined.GetPrimAtPath(prim.GetPath())
            assert other and other.GetTypeName() == prim.GetTypeName() and other.GetAppliedSchemas() == prim.GetAppliedSchemas()
            for a in prim.GetAttributes():
                b = other.GetAttribute(a.GetName())
                assert not a.HasAuthoredValue() or a.Get(index) == b.Get(index), (index, a.GetPath())
                assert a.GetMetadata("interpolation") == b.GetMetadata("interpolation"), a.GetPath()
            for a in prim.GetRelationships():
                assert a.GetTargets() == other.GetRelationship(a.GetName()).GetTargets(), a.GetPath()
    # Between two frames the first one's surface stays: their triangles differ, also where they have as many vertices.
    for index in range(max(frames)):
        for name in SURFACES:
            points = UsdGeom.Mesh(joined.GetPrimAtPath(f"/meltsim/{name}")).GetPointsAttr()
            assert points.Get(index + 0.5) == points.Get(index), (index, name)
    check_extents(joined, frames)
    for path in (out / "scene.usda", out / "frames" / "manifest.usda", frames[0], frames[max(frames)]):
        check_valid(path)
    return joined


with tempfile.TemporaryDirectory() as folder:
    def run(name, *options, code=0):
        out = Path(folder) / name
        done = subprocess.run([meltsim, "run", scene, "--backend", "cpu", "--out", out, "--export", "usd,ply", "--no-page", "--no-still",
                               "--quiet", *options])
        assert done.returncode == code, (name, done.returncode)
        return out

    out = run("plain", "--frames", "4")
    numbers = []
    for index, path in frames_of(out).items():
        numbers.append(check_frame(path, index))
        ply = (out / "frames" / f"particles_{index:05}.ply").read_bytes()
        assert f"element vertex {numbers[-1]}\n".encode() in ply
    assert len(numbers) == 5 and len(set(numbers)) > 1, numbers
    stage = check_joined(out)
    water = UsdShade.Shader(stage.GetPrimAtPath("/meltsim/materials/liquid/surface"))
    assert abs(water.GetInput("ior").Get() - 1.333) < 1e-6 and water.GetInput("opacity").Get() < 0.5

    # A shorter run over it leaves later frames out.
    run("plain", "--frames", "2", "--overwrite")
    stage.Reload()
    assert stage.GetEndTimeCode() == 2 and len(frames_of(out)) == 5

    # A run that is stopped plays as far as it came; one that is resumed plays as a whole.
    process = subprocess.Popen([meltsim, "run", scene, "--backend", "cpu", "--out", Path(folder) / "cut", "--export", "usd", "--time", "2", "--quiet"],
                               stderr=subprocess.DEVNULL)
    while process.poll() is None and not (Path(folder) / "cut" / "frames" / "scene.00003.usda").exists():
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=120) == 130
    reached = max(frames_of(Path(folder) / "cut"))
    stage = check_joined(Path(folder) / "cut")
    assert stage.GetEndTimeCode() == reached
    del stage  # its layers would be kept
    out = run("cut", "--resume", "--frames", str(reached + 2))
    assert max(frames_of(out)) == reached + 2
    check_joined(out)

    # Frames without liquid, without solids, and without anything.
    for name, options in (("dry", ["--set", "fluids=[]", "--set", "emitters=[]"]), ("wet", ["--set", "bodies=[]"]),
                          ("void", ["--set", "fluids=[]", "--set", "emitters=[]", "--set", "bodies=[]"])):
        out = run(name, "--frames", "1", *options)
        for index, path in frames_of(out).items():
            check_frame(path, index)
        check_joined(out)
    # Everything melts: the solid of the last frames is a mesh without points.
    out = run("melted", "--set", "heat.time_scale=1e7", "--set", "time.end_when=melted", "--set", "time.end=20")
    stage = check_joined(out)
    solid = UsdGeom.Mesh(stage.GetPrimAtPath("/meltsim/solid")).GetPointsAttr()
    assert len(solid.Get(0)) > 0 and len(solid.Get(max(frames_of(out)))) == 0

    # A clear liquid that holds ink is clear here and coloured there.
    ink = "materials.ink={density: 1000, dissolves_in: water, diffusivity_in: 1e-9, color: [0.1, 0.1, 0.7]}"
    out = run("ink", "--frames", "2", "--set", ink, "--set", "emitters[0].fractions={ink: 0.5}")
    for index, path in frames_of(out).items():
        check_frame(path, index)
    stage = check_joined(out)
    liquid = stage.GetPrimAtPath("/meltsim/liquid")
    assert all(len(UsdGeom.Subset(stage.GetPrimAtPath(f"/meltsim/liquid/{name}")).GetIndicesAttr().Get(2)) > 0 for name in ("liquid", "dyed"))
    assert max(UsdGeom.PrimvarsAPI(liquid).GetPrimvar("w_ink").Get(2)) > 0.4
    assert max(UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/meltsim/particles")).GetPrimvar("w_ink").Get(2)) > 0.4
    opacity = UsdGeom.PrimvarsAPI(liquid).GetPrimvar("displayOpacity").Get(2)
    assert min(opacity) < 0.5 and max(opacity) == 1
print("ok")
