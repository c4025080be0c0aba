# SPDX-License-Identifier: Apache-2.0
"""Shapes of results, for type checkers."""
from __future__ import annotations

from typing import Tuple, TypedDict

Vector = Tuple[float, float, float]


class Forces(TypedDict):
    """What acted on a body, as of take_forces(): impulses [N s] and angular impulses [N m s], heat [J]; pose and velocities at the end."""

    seconds: float
    impulse: Vector
    angular_impulse: Vector
    pressure: Vector
    pressure_angular: Vector
    viscosity: Vector
    viscosity_angular: Vector
    contact: Vector
    contact_angular: Vector
    heat: float
    position: Vector
    orientation: Tuple[float, float, float, float]
    velocity: Vector
    angular_velocity: Vector
