# SPDX-License-Identifier: Apache-2.0
"""Melting and flowing, with particles. SI units, temperatures in degrees Celsius, y is up.

>>> import meltsim
>>> world = meltsim.World.load("ice_block", scale=0.5)
>>> world.run(1.0)
>>> world.show()
"""
from ._core import (Body, Emitter, ForceField, HeatRegion, Ledger, Material, ParticleFrame, Particles, Piece, Probe, Reading, RenderPack, Resolved,
                    Settled, Shape, State, StepResult, Stiffness, Surface, SurfaceView, TimedStep, Totals, build_info, scenes)
from ._error import Error
from ._types import Forces
from ._world import Page, World

__version__ = build_info()["version"]
__all__ = ["Body", "Emitter", "Error", "ForceField", "Forces", "HeatRegion", "Ledger", "Material", "Page", "ParticleFrame", "Particles", "Piece", "Probe",
           "Reading", "RenderPack", "Resolved", "Settled", "Shape", "State", "StepResult", "Stiffness", "Surface", "SurfaceView", "TimedStep", "Totals", "World",
           "build_info", "scenes"]
