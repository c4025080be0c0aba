# SPDX-License-Identifier: Apache-2.0
"""usd_reader.py MELTSIM SCENE: a run with --export usd, opened by USD itself (usd-core from PyPI). Ends with 77 where that is not
installed."""
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    from pxr import Usd, UsdGeom
except ImportError:
    print("usd-core is not installed: pip install usd-core")
    sys.exit(77)

meltsim, scene = sys.argv[1:3]
with tempfile.TemporaryDirectory() as folder:
    out = Path(folder) / "run"
    subprocess.run([meltsim, "run", scene, "--out", out, "--export", "usd,ply", "--frames", "2", "--no-page"], check=True,
                   stdout=subprocess.DEVNULL)
    files = sorted((out / "frames").glob("scene_*.usda"))
    assert files, "no frame was written"
    for path in files:
        stage = Usd.Stage.Open(str(path))
        assert stage.GetDefaultPrim().GetName() == "meltsim" and UsdGeom.GetStageMetersPerUnit(stage) == 1
        points = UsdGeom.Points(stage.GetPrimAtPath("/meltsim/particles"))
        n = len(points.GetPointsAttr().Get())
        assert n > 0 and len(points.GetIdsAttr().Get()) == n and len(points.GetVelocitiesAttr().Get()) == n
        primvars = UsdGeom.PrimvarsAPI(points)
        for name in ("temperature", "liquid_fraction", "body", "material"):
            primvar = primvars.GetPrimvar(name)
            assert primvar.GetInterpolation() == "vertex" and len(primvar.Get()) == n, name
        bodies = set(primvars.GetPrimvar("body").Get())
        assert -1 in bodies and len(bodies) > 1, bodies
        # As many particles as the PLY of the same frame says.
        ply = (out / "frames" / path.name.replace("scene", "particles").replace("usda", "ply")).read_bytes()
        assert f"element vertex {n}\n".encode() in ply
        extent = points.GetExtentAttr().Get()
        low = [min(p[k] for p in points.GetPointsAttr().Get()) for k in range(3)]
        half = points.GetWidthsAttr().Get()[0] / 2
        assert all(abs(extent[0][k] - (low[k] - half)) < 1e-6 for k in range(3))
        for name in ("liquid", "solid"):
            mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/meltsim/{name}"))
            vertices, counts, indices = (a.Get() for a in (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()))
            assert set(counts) <= {3} and len(indices) == 3 * len(counts) and max(indices, default=-1) < len(vertices)
            assert len(mesh.GetNormalsAttr().Get()) == len(vertices)
            for primvar in ("temperature", "liquid_fraction", "body", "material"):
                assert len(UsdGeom.PrimvarsAPI(mesh).GetPrimvar(primvar).Get()) == len(vertices), primvar
            assert UsdGeom.Mesh.ValidateTopology(indices, counts, len(vertices))[0]
    print(f"{len(files)} frames, {n} particles")
