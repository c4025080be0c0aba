# SPDX-License-Identifier: Apache-2.0
"""A force of your own on device memory: an array library writes accelerations inside the sub-step, without a copy. NumPy on the CPU,
CuPy (or PyTorch, by its from_dlpack) on CUDA, by the same lines. A drop in space is spun up; what the force gave it is compared with what it
has. Arguments: the backend, cpu or cuda."""
import contextlib
import sys

import numpy as np
from meltsim import Shape, World

backend = sys.argv[1] if len(sys.argv) > 1 else "cpu"
if backend == "cuda":
    import cupy as xp
else:
    xp = np
SPACING, DENSITY, SPIN, GRIP = 0.025, 1000.0, 3.0, 20.0  # m, kg/m^3, rad/s, 1/s
MASS = DENSITY * SPACING**3

world = World(spacing=SPACING, gravity=(0, 0, 0), backend=backend, heat_model="none", sound_speed=20, precision="double")
world.add_material("water", density=DENSITY, viscosity=0)  # a pair then pushes along its line, which keeps angular momentum
world.add_fluid(Shape.sphere((0, 0, 0), 0.2), "water")
given = xp.zeros(1)  # angular impulse about z so far [N m s]: stays where the World is


def spin(state):
    """Pulls the velocity of what is off the axis towards that of a turn at SPIN about z."""
    on_stream = xp.cuda.Stream.from_external(state) if backend == "cuda" else contextlib.nullcontext()
    with on_stream:
        x, v, a = (xp.from_dlpack(array) for array in (state.position, state.velocity, state.acceleration))
        outside = x[:, 0] ** 2 + x[:, 1] ** 2 > 0.1**2
        pull = xp.stack([-SPIN * x[:, 1] - v[:, 0], SPIN * x[:, 0] - v[:, 1]], axis=1) * (GRIP * outside[:, None])
        a[:, :2] += pull
        given[:] += (x[:, 0] * pull[:, 1] - x[:, 1] * pull[:, 0]).sum() * MASS * state.dt


world.add_stage("spin", spin)
for _ in range(25):
    world.step(0.02)
world.synchronize()
has = world.totals().angular_momentum[2]
print(f"{world.backend}: {world.steps} sub-steps; angular momentum {has:.9f} N m s, given {float(given[0]):.9f} N m s, "
      f"difference {abs(has / float(given[0]) - 1):.1e}")
